//! Nothing to use: this package holds the integration tests in `palpate/`.

/// The example of the page on compression is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../../docs/compression.md")]
pub struct CompressionPage;
