  float probabilities[TAXEL_@NAME@_CLASSES];
  taxel_@name@_predict_latest(probabilities);
  unsigned int first = 0;
  for (unsigned int i = 0; i < TAXEL_@NAME@_ATTRIBUTES; i++) {
    const unsigned int end = first + taxel_@name@_attribute_classes[i];
    unsigned int best = first;
    for (; first < end; first++) {
      if (probabilities[first] > probabilities[best]) {
        best = first;
      }
    }
    Serial.print(taxel_@name@_attribute_names[i]);
    Serial.print(' ');
    Serial.print(taxel_@name@_class_names[best]);
    Serial.print(' ');
    Serial.println(probabilities[best]);
  }
