/* As much of ESP-IDF's header as the example needs, to compile it. */
#ifndef SHIM_ESP_ERR_H
#define SHIM_ESP_ERR_H
typedef int esp_err_t;
#define ESP_OK 0
void shim_check(esp_err_t error);
#define ESP_ERROR_CHECK(expression) shim_check(expression)
#endif
