//! The JPEG-LS decoder, against `CharLS`.
