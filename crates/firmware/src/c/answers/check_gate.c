        expect("distance", i, bits_of(taxel_@name@_distance(row)), expected_distance[i]);
        expect("unknown", i, (uint32_t)taxel_@name@_is_unknown(row), expected_unknown[i]);
