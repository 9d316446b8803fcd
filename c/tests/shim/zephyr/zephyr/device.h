/* As much of Zephyr's header as the sample needs, to compile it. */
#ifndef SHIM_DEVICE_H
#define SHIM_DEVICE_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
struct device {
    const char *name;
};
extern const struct device shim_device;
#define DT_ALIAS(alias) alias
#define DEVICE_DT_GET(node) (&shim_device)
bool device_is_ready(const struct device *device);
#endif
