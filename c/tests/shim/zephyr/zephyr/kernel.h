/* As much of Zephyr's header as the sample needs, to compile it. */
#ifndef SHIM_KERNEL_H
#define SHIM_KERNEL_H
#include <stdint.h>
int32_t k_msleep(int32_t ms);
uint32_t k_uptime_get_32(void);
void printk(const char *format, ...);
#endif
