/* As much of FreeRTOS's header as the example needs, to compile it. */
#ifndef SHIM_TASK_H
#define SHIM_TASK_H
#include "freertos/FreeRTOS.h"
void vTaskDelay(TickType_t ticks);
#endif
