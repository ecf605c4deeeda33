// Reads one image after the other and prints what the model says of it.
#include <taxel_@name@.h>

static float sample[TAXEL_@NAME@_VALUES];

// Put the values of your sensor here, in the unit and order of the training data: row after row.
static void read_sensor(float image[TAXEL_@NAME@_VALUES]) {
  for (unsigned int row = 0; row < TAXEL_@NAME@_ROWS; row++) {
    for (unsigned int column = 0; column < TAXEL_@NAME@_COLUMNS; column++) {
      image[row * TAXEL_@NAME@_COLUMNS + column] = (float)analogRead(A0);
    }
  }
}

void setup() {
  Serial.begin(115200);
}

void loop() {
  read_sensor(sample);
@print@  delay(@period_ms@);
}
