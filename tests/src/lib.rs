//! Nothing to use: this package holds the integration tests in `palpate/`.
