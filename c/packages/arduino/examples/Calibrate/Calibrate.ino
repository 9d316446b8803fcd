// Calibrates a QMC5883L (address 0x0D) and prints the corrected field in uT.
//
// Open the serial monitor at 115200 baud and turn the board as it says. Axes: x forward, y right, z down; if your module
// is mounted otherwise, exchange and negate the counts in readSample first.

#include <Wire.h>
#include <ironout.h>

static const uint8_t ADDRESS = 0x0D;

// Range 8 G: 3000 counts per gauss, 100 uT per gauss. 100 samples per second. The field here: 48.5 uT (0 if unknown).
static const ironout_sensor sensor = { { 1.0f / 30, 1.0f / 30, 1.0f / 30 }, 100.0f, 48.5f };
static ironout_session session;
static ironout_calibration calibration;
static bool calibrated = false;
static uint32_t lastHintMs = 0;

static void writeRegister(uint8_t place, uint8_t value)
{
    Wire.beginTransmission(ADDRESS);
    Wire.write(place);
    Wire.write(value);
    Wire.endTransmission();
}

// One conversion, if there is a new one: six bytes of counts, then the status.
static bool readSample(int16_t counts[3], uint32_t &flags)
{
    Wire.beginTransmission(ADDRESS);
    Wire.write((uint8_t)0x06);
    Wire.endTransmission();
    Wire.requestFrom(ADDRESS, (uint8_t)1);
    uint8_t status = (uint8_t)Wire.read();
    if ((status & 1) == 0)
        return false;
    Wire.beginTransmission(ADDRESS);
    Wire.write((uint8_t)0x00);
    Wire.endTransmission();
    Wire.requestFrom(ADDRESS, (uint8_t)6);
    for (int axis = 0; axis < 3; axis++) {
        uint16_t low = (uint16_t)Wire.read();
        uint16_t high = (uint16_t)Wire.read();
        counts[axis] = (int16_t)(uint16_t)(high << 8 | low);
    }
    flags = (status & 2) != 0 ? IRONOUT_OUT_OF_RANGE : 0;
    return true;
}

void setup()
{
    Serial.begin(115200);
    Wire.begin();
    writeRegister(0x0B, 0x01); // set/reset period
    writeRegister(0x09, 0x19); // continuous, 100 Hz, 8 G
    ironout_session_init(&session, &sensor);
}

static void calibrate(const int16_t counts[3], uint32_t flags)
{
    ironout_session_push(&session, counts, millis(), flags);
    if (millis() - lastHintMs < 1000)
        return;
    lastHintMs = millis();
    ironout_status status;
    char hint[100];
    ironout_session_status(&session, &status);
    ironout_hint_text(&status, hint, sizeof hint);
    Serial.println(hint);
    if (status.hint != IRONOUT_HINT_STOP)
        return;
    ironout_error error = ironout_session_stop(&session, nullptr);
    if (error == IRONOUT_OK) {
        // To keep it over a restart: ironout_record_encode, then write the bytes to EEPROM or flash.
        calibrated = ironout_session_accept(&session, &calibration) == IRONOUT_OK;
        Serial.print("accepted; predicted error in uT: ");
        Serial.println(calibration.predicted_error_ut);
    } else {
        Serial.println(ironout_error_text(error));
        ironout_session_init(&session, &sensor);
    }
}

void loop()
{
    int16_t counts[3];
    uint32_t flags;
    if (!readSample(counts, flags))
        return;
    if (!calibrated) {
        calibrate(counts, flags);
        return;
    }
    float field[3];
    ironout_apply_counts(&calibration, &sensor, counts, field);
    if (millis() - lastHintMs >= 1000) {
        lastHintMs = millis();
        Serial.print(field[0]);
        Serial.print(' ');
        Serial.print(field[1]);
        Serial.print(' ');
        Serial.println(field[2]);
    }
}
