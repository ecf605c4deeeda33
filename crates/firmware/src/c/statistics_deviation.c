if (s->kind == 2u) {
                sum = 0.0f;
                for (at = 0; at < positions; at++) {
                    const float apart = less(row[at], result);
                    sum = plus(sum, times(apart, apart));
                }
                result = root(plus(times(sum, s->share), s->eps));
            }
