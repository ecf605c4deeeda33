// Reads one time step of the sensor after the other and prints what the model says of the last ones.
#include <taxel_@name@.h>

// Time between two time steps in microseconds@rate@.
static const unsigned long PERIOD_US = @period@;
static unsigned long next_step;

// Put the values of your sensor here, in the unit and order of the training data.
static void read_sensor(float step[TAXEL_@NAME@_CHANNELS]) {
  for (unsigned int channel = 0; channel < TAXEL_@NAME@_CHANNELS; channel++) {
    step[channel] = (float)analogRead((int)(A0 + channel));
  }
}

void setup() {
  Serial.begin(115200);
  next_step = micros();
}

void loop() {
  if ((long)(micros() - next_step) < 0) {
    return;
  }
  next_step += PERIOD_US;
  float step[TAXEL_@NAME@_CHANNELS];
  read_sensor(step);
  if (taxel_@name@_push(step) != 0 || !taxel_@name@_ready()) {
    return;
  }
@print@  // The next prediction needs new time steps alone.
  taxel_@name@_clear();
}
