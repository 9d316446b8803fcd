// The bus of the stand-in: one simulated QMC5883L.

#ifndef SHIM_WIRE_H
#define SHIM_WIRE_H

#include "Arduino.h"

struct WireShim {
    void begin() {}
    void beginTransmission(uint8_t address);
    void write(uint8_t byte);
    uint8_t endTransmission();
    uint8_t requestFrom(uint8_t address, uint8_t count);
    int read();

    uint8_t registers[16];
    uint8_t place, written, address;
};

extern WireShim Wire;

#endif
