// Runs the sketch for 40 s of simulated time on a board that is turned, and says whether it calibrated: its last field
// has to be as long as the field, within 2 %.

#include "Calibrate.ino"
#include <math.h>

uint32_t shim_ms = 0;
SerialShim Serial;
WireShim Wire;

static uint64_t seed = 5;

static double noise()
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++) {
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        sum += static_cast<double>(seed >> 33) / 2147483648.0 - 0.5;
    }
    return sum;
}

static void measure()
{
    const double t = shim_ms * 0.001, turn = 2.1 * t, tilt = 0.83 * t + 0.4, field = 48.5;
    const double at[3] = { field * cos(tilt) * cos(turn), field * cos(tilt) * sin(turn), field * sin(tilt) };
    // Offset, gains and a leaning axis; counts of 1/30 uT.
    const double measured[3] = { 1.08 * at[0] + 0.05 * at[1] + 37.0, 0.94 * at[1] - 21.0, 1.02 * at[2] + 64.0 };
    for (int axis = 0; axis < 3; axis++) {
        const int16_t count = static_cast<int16_t>(lround((measured[axis] + 0.3 * noise()) * 30.0));
        Wire.registers[2 * axis] = static_cast<uint8_t>(count & 0xff);
        Wire.registers[2 * axis + 1] = static_cast<uint8_t>((count >> 8) & 0xff);
    }
    Wire.registers[6] = 1;
}

void WireShim::beginTransmission(uint8_t to)
{
    address = to;
    written = 0;
}

void WireShim::write(uint8_t byte)
{
    if (address != 0x0D)
        return;
    if (written++ == 0)
        place = byte & 15;
    else
        registers[place++ & 15] = byte;
}

uint8_t WireShim::endTransmission() { return 0; }

uint8_t WireShim::requestFrom(uint8_t from, uint8_t count)
{
    // The status is asked for once a turn of the loop: the next conversion, if the chip measures at 100 Hz and 8 G.
    if (place == 6 && registers[9] == 0x19 && registers[11] == 1) {
        shim_ms += 10;
        measure();
    }
    return from == 0x0D ? count : 0;
}

int WireShim::read() { return registers[place++ & 15]; }

int main()
{
    setup();
    while (shim_ms < 40000)
        loop();
    int16_t counts[3];
    uint32_t flags;
    float corrected[3] = { 0.0f, 0.0f, 0.0f };
    if (!calibrated || !readSample(counts, flags))
        return 1;
    ironout_apply_counts(&calibration, &sensor, counts, corrected);
    const float length = sqrtf(corrected[0] * corrected[0] + corrected[1] * corrected[1] + corrected[2] * corrected[2]);
    return fabsf(length / 48.5f - 1.0f) < 0.02f ? 0 : 1;
}
