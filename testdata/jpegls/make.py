"""Makes JPEG-LS frames and the samples that CharLS decodes from them.

    python make.py DIR          the few vectors that are kept beside this file
    python make.py DIR --many   some hundreds, of all sizes, depths, NEAR and presets

Needs numpy, pyjpegls 1.5.1 (CharLS encodes), imagecodecs 2026.3.6 (CharLS 2.4.3 decodes) and
pylibjpeg-libjpeg 2.5.0. Frames that CharLS does not write (presets, restart markers, fill bytes)
come from the small encoder below. What is expected is what CharLS decodes; CharLS takes no MAXVAL
but the largest (and not every large RESET), so libjpeg, the reference software of JPEG XT, is asked
there. A lossless frame
must also give back the image that went in.
Each frame is NAME.jls with NAME.raw (u16, little-endian), listed in index.txt:
name, rows, columns, bits, NEAR.
"""

import pathlib
import sys

import imagecodecs
import jpeg_ls
import libjpeg
import numpy as np

J = [0] * 4 + [1] * 4 + [2] * 4 + [3] * 4 + [4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15]


class Writer:
    """Bits with a 0 stuffed after each FF."""

    def __init__(self):
        self.out, self.byte, self.room = bytearray(), 0, 8

    def put(self, value, count):
        for i in reversed(range(count)):
            self.room -= 1
            self.byte |= (value >> i & 1) << self.room
            if self.room == 0:
                self.flush_byte()

    def flush_byte(self):
        self.out.append(self.byte)
        self.room = 7 if self.byte == 0xFF else 8
        self.byte = 0

    def finish(self):
        full = 7 if self.out and self.out[-1] == 0xFF else 8
        if self.room < full or full == 7:
            self.flush_byte()
        return bytes(self.out)


def clip(t, least, maxval):
    return least if t > maxval or t < least else t


def defaults(maxval, near):
    if maxval >= 128:
        f = (min(maxval, 4095) + 128) // 256
        t = [f + 2 + 3 * near, 4 * f + 3 + 5 * near, 17 * f + 4 + 7 * near]
    else:
        f = 256 // (maxval + 1)
        t = [max(2, 3 // f + 3 * near), max(3, 7 // f + 5 * near), max(4, 21 // f + 7 * near)]
    t[0] = clip(t[0], near + 1, maxval)
    t[1] = clip(t[1], t[0], maxval)
    t[2] = clip(t[2], t[1], maxval)
    return t


class Encoder:
    """T.87, annex A, one component."""

    def __init__(self, maxval, near, t, reset):
        self.maxval, self.near, self.t, self.reset = maxval, near, t, reset
        self.step = 2 * near + 1
        self.range = (maxval + 2 * near) // self.step + 1
        self.qbpp = (self.range - 1).bit_length()
        bpp = max(2, maxval.bit_length())
        self.limit = 2 * (bpp + max(8, bpp))

    def interval(self, image):
        rows, cols = image.shape
        a0 = max(2, (self.range + 32) // 64)
        self.a, self.b, self.c, self.n = [a0] * 367, [0] * 365, [0] * 365, [1] * 367
        self.nn, self.run = [0, 0], 0
        self.w = Writer()
        above = [0] * (cols + 2)
        for row in image.tolist():
            line = [above[1]] + [0] * (cols + 1)
            self.line(row, above, line, cols)
            line[cols + 1] = line[cols]
            above = line
        return self.w.finish()

    def q(self, d):
        m = abs(d)
        r = 0 if m <= self.near else 1 + sum(m >= t for t in self.t)
        return -r if d < 0 else r

    def golomb(self, value, k, limit):
        escape = limit - self.qbpp - 1
        if value >> k < escape:
            self.w.put(1, (value >> k) + 1)
            self.w.put(value & (1 << k) - 1, k)
        else:
            self.w.put(1, escape + 1)
            self.w.put(value - 1, self.qbpp)

    def quantise(self, error):
        if self.near:
            error = (error + self.near) // self.step if error > 0 else -((self.near - error) // self.step)
        return error

    def ring(self, error):
        if error < 0:
            error += self.range
        return error - self.range if error >= (self.range + 1) // 2 else error

    def rebuilt(self, guess, error, sample):
        if not self.near:
            return sample
        return min(max(guess + error * self.step, 0), self.maxval)

    def k(self, a, n):
        k = 0
        while n << k < a:
            k += 1
        return k

    def line(self, row, above, line, cols):
        x = 0
        while x < cols:
            a, b, c, d = line[x], above[x + 1], above[x], above[x + 2]
            ctx = 81 * self.q(d - b) + 9 * self.q(b - c) + self.q(c - a)
            if ctx == 0:
                x = self.runs(row, above, line, cols, x)
                continue
            sign = -1 if ctx < 0 else 1
            i = abs(ctx)
            guess = min(a, b) if c >= max(a, b) else max(a, b) if c <= min(a, b) else a + b - c
            guess = min(max(guess + sign * self.c[i], 0), self.maxval)
            error = self.quantise(sign * (row[x] - guess))
            line[x + 1] = self.rebuilt(guess, sign * error, row[x])
            error = self.ring(error)
            k = self.k(self.a[i], self.n[i])
            if self.near == 0 and k == 0 and 2 * self.b[i] <= -self.n[i]:
                mapped = 2 * error + 1 if error >= 0 else -2 * (error + 1)
            else:
                mapped = 2 * error if error >= 0 else -2 * error - 1
            self.golomb(mapped, k, self.limit)
            self.b[i] += error * self.step
            self.a[i] += abs(error)
            if self.n[i] == self.reset:
                self.a[i] >>= 1
                self.b[i] = self.b[i] >> 1 if self.b[i] >= 0 else -((1 - self.b[i]) >> 1)
                self.n[i] >>= 1
            self.n[i] += 1
            if self.b[i] <= -self.n[i]:
                self.b[i] = max(self.b[i] + self.n[i], 1 - self.n[i])
                self.c[i] = max(self.c[i] - 1, -128)
            elif self.b[i] > 0:
                self.b[i] = min(self.b[i] - self.n[i], 0)
                self.c[i] = min(self.c[i] + 1, 127)
            x += 1

    def runs(self, row, above, line, cols, x):
        a, count = line[x], 0
        while x < cols and abs(row[x] - a) <= self.near:
            line[x + 1] = a
            x, count = x + 1, count + 1
        while count >= 1 << J[self.run]:
            self.w.put(1, 1)
            count -= 1 << J[self.run]
            self.run = min(self.run + 1, 31)
        if x == cols:
            if count:
                self.w.put(1, 1)
            return x
        self.w.put(0, 1)
        self.w.put(count, J[self.run])
        b = above[x + 1]
        same = int(abs(a - b) <= self.near)
        guess = a if same else b
        sign = -1 if not same and a > b else 1
        error = self.quantise(sign * (row[x] - guess))
        line[x + 1] = self.rebuilt(guess, sign * error, row[x])
        error = self.ring(error)
        i = 365 + same
        k = self.k(self.a[i] + same * (self.n[i] >> 1), self.n[i])
        nn = self.nn[same]
        if k == 0 and error > 0 and 2 * nn < self.n[i]:
            bit = 1
        else:
            bit = int(error < 0 and (2 * nn >= self.n[i] or k != 0))
        mapped = 2 * abs(error) - same - bit
        self.golomb(mapped, k, self.limit - J[self.run] - 1)
        self.nn[same] += error < 0
        self.a[i] += (mapped + 1 - same) >> 1
        if self.n[i] == self.reset:
            self.a[i] >>= 1
            self.n[i] >>= 1
            self.nn[same] >>= 1
        self.n[i] += 1
        self.run = max(self.run - 1, 0)
        return x + 1


def words(*values):
    return b"".join(v.to_bytes(2, "big") for v in values)


def encode(image, bits, near=0, preset=None, interval=0, wide=2, extra=b"", fill=b"", dnl=False):
    """preset: (MAXVAL, T1, T2, T3, RESET), 0 for a default."""
    rows, cols = image.shape
    m, t1, t2, t3, reset = preset or (0,) * 5
    maxval = m or (1 << bits) - 1
    t = [given or default for given, default in zip((t1, t2, t3), defaults(maxval, near))]
    out = b"\xff\xd8" + extra
    out += b"\xff\xf7" + words(11) + bytes([bits]) + words(0 if dnl else rows, cols) + bytes([1, 1, 0x11, 0])
    if preset:
        out += fill + b"\xff\xf8" + words(13) + b"\x01" + words(m, t1, t2, t3, reset)
    if interval:
        out += b"\xff\xdd" + words(2 + wide) + interval.to_bytes(wide, "big")
    out += fill + b"\xff\xda" + words(8) + bytes([1, 1, 0, near, 0, 0])
    coder = Encoder(maxval, near, t, reset or 64)
    for number, top in enumerate(range(0, rows, interval or rows)):
        if number:
            out += fill + bytes([0xFF, 0xD0 + (number - 1) % 8])
        out += coder.interval(image[top : top + (interval or rows)])
    if dnl:
        out += b"\xff\xdc" + words(4, rows)
    return out + fill + b"\xff\xd9"


def images(random, rows, cols, maxval):
    y, x = np.mgrid[0:rows, 0:cols]
    wave = np.sin(x / 7.0) + np.cos(y / 11.0) + x / max(cols, 1)
    smooth = (wave - wave.min()) / max(np.ptp(wave), 1e-9) * maxval
    steps = random.integers(0, maxval + 1, (rows // 5 + 1, cols // 9 + 1)).repeat(5, 0).repeat(9, 1)
    sparse = np.where(random.random((rows, cols)) < 0.02, maxval, 0)
    bell = np.clip(smooth + random.normal(0, maxval / 200 + 0.6, (rows, cols)), 0, maxval)
    made = {
        "noise": random.integers(0, maxval + 1, (rows, cols)),
        "smooth": smooth,
        "bell": bell,
        "steps": steps[:rows, :cols],
        "sparse": sparse,
        "flat": np.full((rows, cols), random.integers(0, maxval + 1)),
        "zero": np.zeros((rows, cols)),
        "full": np.full((rows, cols), maxval),
        "checks": (x + y) % 2 * maxval,
        "low": random.integers(0, min(maxval, 2) + 1, (rows, cols)),
    }
    return {name: image.astype(np.uint16) for name, image in made.items()}


class Folder:
    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.path.mkdir(parents=True, exist_ok=True)
        self.index = []

    def add(self, name, stream, image, bits, near, judge=imagecodecs.jpegls_decode):
        if judge:
            back = judge(stream).astype(np.uint16).reshape(image.shape)
            worst = int(np.abs(back.astype(int) - image).max())
            assert worst <= near, (name, worst, near)
        else:
            assert near == 0
            back = image
        (self.path / f"{name}.jls").write_bytes(stream)
        back.astype("<u2").tofile(self.path / f"{name}.raw")
        self.index.append(f"{name} {image.shape[0]} {image.shape[1]} {bits} {near}\n")

    def close(self):
        (self.path / "index.txt").write_text("".join(self.index))


def either(stream):
    try:
        return imagecodecs.jpegls_decode(stream)
    except imagecodecs.JpeglsError:
        return libjpeg.decode(stream)


def charls(image, bits, near):
    dtype = "u1" if bits <= 8 else "<u2"
    try:
        stream = jpeg_ls.encode_buffer(image.astype(dtype).tobytes(), *image.shape, 1, bits, near)
    except RuntimeError:  # its buffer has no room for the header of a small image
        return encode(image, bits, near)
    return bytes(stream)


def few(folder):
    random = np.random.default_rng(87)
    pick = lambda rows, cols, maxval, kind: images(random, rows, cols, maxval)[kind]
    for bits, kind, shape in [(2, "low", (9, 31)), (8, "bell", (24, 40)), (12, "bell", (24, 40)),
                              (16, "noise", (12, 20)), (16, "smooth", (24, 40)), (12, "sparse", (40, 70))]:
        image = pick(*shape, (1 << bits) - 1, kind)
        folder.add(f"charls-{bits}-{kind}", charls(image, bits, 0), image, bits, 0)
    for bits, near in [(8, 1), (12, 3), (16, 10)]:
        image = pick(24, 40, (1 << bits) - 1, "bell")
        folder.add(f"charls-{bits}-near-{near}", charls(image, bits, near), image, bits, near)
    for shape in [(1, 1), (1, 33), (33, 1)]:
        image = pick(*shape, 4095, "bell")
        folder.add(f"charls-12-{shape[0]}x{shape[1]}", charls(image, 12, 0), image, 12, 0)
    image = pick(24, 40, 3000, "bell")
    preset = (3000, 9, 40, 200, 31)
    folder.add("preset-12", encode(image, 12, 0, preset), image, 12, 0, libjpeg.decode)
    folder.add("preset-12-near-2", encode(image, 12, 2, preset), image, 12, 2, libjpeg.decode)
    preset = (4095, 9, 40, 200, 31)
    folder.add("preset-12-full", encode(image, 12, 0, preset), image, 12, 0)
    folder.add("restart-12", encode(image, 12, interval=2), image, 12, 0)
    folder.add("restart-12-wide", encode(image, 12, 1, interval=5, wide=4, fill=b"\xff\xff"), image, 12, 1)
    folder.add("lines-follow-12", encode(image, 12, dnl=True), image, 12, 0, judge=None)
    folder.add("comments-12", encode(image, 12, extra=b"\xff\xe5\x00\x05abc\xff\xfe\x00\x02"), image, 12, 0)


def many(folder):
    random = np.random.default_rng(14495)
    shapes = [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (3, 3), (7, 61), (64, 48), (5, 700)]
    for bits in range(2, 17):
        maxval = (1 << bits) - 1
        for number, (rows, cols) in enumerate(shapes):
            for kind, image in images(random, rows, cols, maxval).items():
                for near in {0, int(random.integers(0, 11))}:
                    near = min(near, maxval // 2)
                    name = f"c{bits}-{rows}x{cols}-{kind}-{near}"
                    folder.add(name, charls(image, bits, near), image, bits, near)
        for trial in range(24):
            rows, cols = (int(v) for v in random.integers(1, 40, 2))
            m = int(random.integers(1, maxval + 1)) if trial % 3 else maxval
            near = int(random.integers(0, min(10, m // 2) + 1)) if trial % 2 else 0
            t = sorted(int(v) for v in random.integers(near + 1, m + 1, 3)) if near < m else [m] * 3
            preset = (m, *t, int(random.integers(3, max(255, m) + 1)))
            if trial % 5 == 0 and m == maxval:
                preset = (m, 0, 0, 0, 0)
            kinds = images(random, rows, cols, m)
            kind = list(kinds)[trial % len(kinds)]
            interval = int(random.integers(1, rows + 2)) if trial % 4 == 0 else 0
            stream = encode(kinds[kind], bits, near, preset, interval, 2 + trial % 3)
            folder.add(f"p{bits}-{trial}-{kind}-{near}", stream, kinds[kind], bits, near,
                       either if m == maxval else libjpeg.decode)


if __name__ == "__main__":
    out = Folder(sys.argv[1])
    (many if "--many" in sys.argv else few)(out)
    out.close()
    print(len(out.index), "frames")
