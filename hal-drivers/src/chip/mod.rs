//! What the chips are: registers, choices, and what bytes mean. Nothing here touches a bus.

pub mod ak09916;
pub mod bmm150;
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
pub mod mmc5983ma;
pub mod qmc5883l;
pub mod qmc5883p;
pub mod rm3100;
pub mod self_test;
