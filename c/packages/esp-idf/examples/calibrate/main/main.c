/* Calibrates a QMC5883L on I2C (SDA 8, SCL 9), then prints the corrected field. */

#include "ironout.h"

#include "driver/i2c_master.h"
#include "esp_err.h"
#include "esp_timer.h"
#include "freertos/FreeRTOS.h"
#include "freertos/task.h"

#include <stdbool.h>
#include <stdio.h>

static i2c_master_dev_handle_t chip;

/* 8 G: 3000 counts per gauss of 100 uT. */
static const ironout_sensor sensor = { { 1.0f / 30, 1.0f / 30, 1.0f / 30 }, 100.0f, 0.0f };
static ironout_session session;
static ironout_calibration calibration;

static void open_chip(void)
{
    i2c_master_bus_handle_t bus;
    const i2c_master_bus_config_t bus_config = {
        .i2c_port = -1, .sda_io_num = 8, .scl_io_num = 9, .clk_source = I2C_CLK_SRC_DEFAULT, .glitch_ignore_cnt = 7,
        .flags.enable_internal_pullup = true,
    };
    const i2c_device_config_t chip_config = {
        .dev_addr_length = I2C_ADDR_BIT_LEN_7, .device_address = 0x0D, .scl_speed_hz = 400000,
    };
    static const uint8_t set_reset[2] = { 0x0B, 0x01 }, control[2] = { 0x09, 0x19 };
    ESP_ERROR_CHECK(i2c_new_master_bus(&bus_config, &bus));
    ESP_ERROR_CHECK(i2c_master_bus_add_device(bus, &chip_config, &chip));
    ESP_ERROR_CHECK(i2c_master_transmit(chip, set_reset, sizeof set_reset, 100));
    ESP_ERROR_CHECK(i2c_master_transmit(chip, control, sizeof control, 100)); /* continuous, 100 Hz, 8 G */
}

/* The next conversion, in the axes of the chip: turn them into the board's here. */
static bool next(int16_t counts[3], uint32_t *flags)
{
    static const uint8_t output = 0x00;
    uint8_t bytes[7];
    int axis;
    vTaskDelay(pdMS_TO_TICKS(10));
    if (i2c_master_transmit_receive(chip, &output, 1, bytes, sizeof bytes, 100) != ESP_OK)
        return false;
    for (axis = 0; axis < 3; axis++)
        counts[axis] = (int16_t)(uint16_t)(bytes[2 * axis] | (uint16_t)bytes[2 * axis + 1] << 8);
    *flags = (bytes[6] & 2) != 0 ? IRONOUT_OUT_OF_RANGE : 0u;
    return true;
}

static ironout_error calibrate(void)
{
    ironout_error error = ironout_session_init(&session, &sensor);
    int taken;
    for (taken = 1; error == IRONOUT_OK; taken++) {
        int16_t counts[3];
        uint32_t flags;
        ironout_status status;
        char hint[100];
        if (!next(counts, &flags))
            continue;
        error = ironout_session_push(&session, counts, (uint32_t)(esp_timer_get_time() / 1000), flags);
        if (taken % 100 != 0 || error != IRONOUT_OK)
            continue;
        ironout_session_status(&session, &status);
        ironout_hint_text(&status, hint, sizeof hint);
        printf("%s\n", hint);
        if (status.hint == IRONOUT_HINT_STOP)
            break;
    }
    if (error == IRONOUT_OK)
        error = ironout_session_stop(&session, NULL);
    if (error == IRONOUT_OK)
        error = ironout_session_accept(&session, &calibration);
    return error;
}

void app_main(void)
{
    ironout_error error;
    open_chip();
    do {
        error = calibrate();
        printf("%s\n", ironout_error_text(error));
    } while (error != IRONOUT_OK);
    for (;;) {
        int16_t counts[3];
        uint32_t flags;
        float field_ut[3];
        if (!next(counts, &flags))
            continue;
        ironout_apply_counts(&calibration, &sensor, counts, field_ut);
        printf("%.2f %.2f %.2f uT\n", (double)field_ut[0], (double)field_ut[1], (double)field_ut[2]);
    }
}
