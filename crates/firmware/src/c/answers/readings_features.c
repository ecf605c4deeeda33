    for (i = @shared@u; i < @numbers@u; i++) {
        numbers[i] = sample[i - @shared@u];
    }
