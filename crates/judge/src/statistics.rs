//! Comparisons of classifiers: each against scipy or a published worked example.
