//! Compression of taxels into contacts (thesis chapter 4).
