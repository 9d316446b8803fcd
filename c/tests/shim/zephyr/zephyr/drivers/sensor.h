/* As much of Zephyr's header as the sample needs, to compile it. */
#ifndef SHIM_SENSOR_H
#define SHIM_SENSOR_H
#include <zephyr/device.h>
struct sensor_value {
    int32_t val1;
    int32_t val2;
};
enum sensor_channel { SENSOR_CHAN_MAGN_XYZ = 11 };
int sensor_sample_fetch(const struct device *device);
int sensor_channel_get(const struct device *device, enum sensor_channel channel, struct sensor_value *value);
static inline float sensor_value_to_float(const struct sensor_value *value)
{
    return (float)value->val1 + (float)value->val2 / 1000000;
}
#endif
