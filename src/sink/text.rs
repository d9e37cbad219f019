//! Numbers as text: the shortest digits that read back as the same `f32`.

/// One line in the making, reused from line to line.
pub(super) struct Line {
    bytes: Vec<u8>,
    floats: zmij::Buffer,
    integers: itoa::Buffer,
}

impl Line {
    pub(super) fn new() -> Self {
        Self {
            bytes: Vec::with_capacity(128),
            floats: zmij::Buffer::new(),
            integers: itoa::Buffer::new(),
        }
    }

    /// Appends a word as it is; meant for the first on the line.
    pub(super) fn word(&mut self, word: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(word);
        self
    }

    /// Appends numbers, each after a space unless it is the first thing on the line.
    pub(super) fn floats(&mut self, values: [f32; 3]) -> &mut Self {
        for value in values {
            self.space();
            self.bytes.extend_from_slice(self.floats.format(value).as_bytes());
        }
        self
    }

    /// Appends an integer after a space.
    pub(super) fn integer(&mut self, value: u32) -> &mut Self {
        self.space();
        self.digits(value)
    }

    /// Appends an integer to what stands there.
    pub(super) fn digits(&mut self, value: u32) -> &mut Self {
        self.bytes.extend_from_slice(self.integers.format(value).as_bytes());
        self
    }

    /// Ends the line and moves it to `out`.
    pub(super) fn end(&mut self, out: &mut Vec<u8>) {
        self.bytes.push(b'\n');
        out.extend_from_slice(&self.bytes);
        self.bytes.clear();
    }

    fn space(&mut self) {
        if !self.bytes.is_empty() {
            self.bytes.push(b' ');
        }
    }
}
