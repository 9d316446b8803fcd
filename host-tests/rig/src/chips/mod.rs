//! Chips for the simulated bus, at the level of their registers.

mod akm;
mod at24c;
mod bmm350;
mod bosch;
mod ecc_flash;
mod field;
mod honeywell;
mod isentek;
mod lsm303dlhc;
mod memsic;
mod pni;
mod qst;
mod register_chip;
mod st;

pub use akm::{Ak09916Model, Icm20948Model, Switch};
pub use at24c::{At24cChip, TornPage};
pub use bmm350::{Bmm350Model, OtpMemory};
pub use bosch::{Bmm150Model, Trimming};
pub use ecc_flash::{EccFlash, SECTOR_BYTES, TornErase};
pub use field::FieldSource;
pub use honeywell::Hmc5883lModel;
pub use isentek::Ist8310Model;
pub use lsm303dlhc::Lsm303dlhcChip;
pub use memsic::{Mmc5603Model, Mmc5983maModel};
pub use pni::Rm3100Model;
pub use qst::{Qmc5883lModel, Qmc5883pModel, Qmc6309Model, Qmc6310Model};
pub use register_chip::{Action, Model, RegisterChip, Registers, World};
pub use st::{Lis2mdlModel, Lis3mdlModel};
