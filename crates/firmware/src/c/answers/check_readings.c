        expect("distance of readings", i, bits_of(taxel_@name@_readings_distance(sample)), expected_far[i]);
        expect("unknown readings", i, (uint32_t)taxel_@name@_readings_are_unknown(sample), expected_strange[i]);
