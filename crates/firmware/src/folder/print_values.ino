  float values[TAXEL_@NAME@_QUANTITIES];
  taxel_@name@_predict_latest(values);
  for (unsigned int i = 0; i < TAXEL_@NAME@_QUANTITIES; i++) {
    Serial.print(taxel_@name@_quantity_names[i]);
    Serial.print(' ');
    Serial.print(values[i], 4);
    Serial.print(' ');
    Serial.println(taxel_@name@_quantity_units[i]);
  }
