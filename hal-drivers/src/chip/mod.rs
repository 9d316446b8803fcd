//! What the chips are: registers, choices, and what bytes mean. Nothing here touches a bus.
//!
//! What the facts rest on. Each file names the maker's document; beyond that, they were compared with:
//!
//! | chip | compared with |
//! |---|---|
//! | LSM303DLHC | the datasheet; QEMU's model of it |
//! | LIS2MDL, IIS2MDC, LSM303AGR | published register lists; the crate `lsm303agr`, whose readings of the same bytes the tests compare |
//! | LIS3MDL | published register lists with the bits of its control registers |
//! | QMC5883L | the datasheet's register map as Tasmota quotes it, and published register lists |
//! | QMC5883P | the register lists of PX4 and RT-Thread |
//! | MMC5983MA | the register lists of PX4 and others |
//! | BMM150 | the datasheet, pages 16 and 22 to 25; Linux for the trimming's registers and the compensation |
//! | QMC6309 | a published register list with the bits of each register; SensorLib and SlimeVR |
//! | QMC6310 | SensorLib's register list, and that of a driver that ran on a T-Beam Supreme; the ±30 000 counts of its overflow are those of the QMC5883P's datasheet |
//! | MMC5603 | Linux, ArduPilot, Zephyr and Betaflight; that the flag falls by reading: a driver of the MMC5616WA alone |
//! | BMM350 | Bosch's sensor API; PX4 |
//! | AK09916 | PX4's register list; AKM's datasheet of the AK09918, whose outputs are the same |
//! | IST8310 | PX4's register list |
//! | RM3100 | Linux and PX4: registers, gains, rates, self-test |
//! | HMC5883L, ICM-20948, L3GD20 family, accelerometers; limits of the self-tests; section and table numbers | nothing: they are from knowledge of the datasheets and were not looked up again |
//!
//! No driver has met its real chip yet. What such a meeting corrects belongs here.

pub mod ak09916;
pub mod bmm150;
pub mod bmm350;
pub mod description;
pub mod hmc5883l;
pub mod icm20948;
pub mod ist8310;
pub mod kind;
pub mod l3gd20;
pub mod lis2mdl;
pub mod lis3mdl;
pub mod lsm303_accelerometer;
pub mod lsm303dlhc;
pub mod mmc5603;
pub mod mmc5983ma;
pub mod qmc5883l;
pub mod qmc5883p;
pub mod qmc6309;
pub mod qmc6310;
pub mod qst;
pub mod rm3100;
pub mod self_test;
pub mod set_reset;
