// As much of the Arduino core as the example needs, printing to standard output; time goes on with the sensor.

#ifndef SHIM_ARDUINO_H
#define SHIM_ARDUINO_H

#include <stdint.h>
#include <stdio.h>

extern uint32_t shim_ms;

inline uint32_t millis() { return shim_ms; }

struct SerialShim {
    void begin(unsigned long) {}
    void print(const char *text) { printf("%s", text); }
    void print(char letter) { printf("%c", letter); }
    void print(float value) { printf("%.2f", static_cast<double>(value)); }
    void println(const char *text) { printf("%s\n", text); }
    void println(float value) { printf("%.2f\n", static_cast<double>(value)); }
};

extern SerialShim Serial;

#endif
