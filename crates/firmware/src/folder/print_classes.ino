  float probabilities[TAXEL_@NAME@_CLASSES];
  taxel_@name@_predict_latest(probabilities);
  unsigned int best = 0;
  for (unsigned int i = 1; i < TAXEL_@NAME@_CLASSES; i++) {
    if (probabilities[i] > probabilities[best]) {
      best = i;
    }
  }
  Serial.print(taxel_@name@_class_names[best]);
  Serial.print(' ');
  Serial.println(probabilities[best]);
