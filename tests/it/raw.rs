//! Raw files, against what numpy sees.
