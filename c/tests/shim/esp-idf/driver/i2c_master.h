/* As much of ESP-IDF's header as the example needs, to compile it. */
#ifndef SHIM_I2C_MASTER_H
#define SHIM_I2C_MASTER_H
#include "esp_err.h"
#include <stddef.h>
#include <stdint.h>
typedef struct shim_bus *i2c_master_bus_handle_t;
typedef struct shim_dev *i2c_master_dev_handle_t;
enum { I2C_CLK_SRC_DEFAULT = 0, I2C_ADDR_BIT_LEN_7 = 0 };
typedef struct {
    int i2c_port, sda_io_num, scl_io_num, clk_source;
    uint8_t glitch_ignore_cnt;
    struct {
        uint32_t enable_internal_pullup : 1;
    } flags;
} i2c_master_bus_config_t;
typedef struct {
    int dev_addr_length;
    uint16_t device_address;
    uint32_t scl_speed_hz;
} i2c_device_config_t;
esp_err_t i2c_new_master_bus(const i2c_master_bus_config_t *config, i2c_master_bus_handle_t *bus);
esp_err_t i2c_master_bus_add_device(i2c_master_bus_handle_t bus, const i2c_device_config_t *config,
                                    i2c_master_dev_handle_t *device);
esp_err_t i2c_master_transmit(i2c_master_dev_handle_t device, const uint8_t *bytes, size_t size, int timeout_ms);
esp_err_t i2c_master_transmit_receive(i2c_master_dev_handle_t device, const uint8_t *bytes, size_t size,
                                      uint8_t *read, size_t read_size, int timeout_ms);
#endif
