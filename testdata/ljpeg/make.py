"""Makes lossless JPEG frames and the samples that SimpleITK decodes from them.

    python make.py DIR          the few frames that are kept beside this file
    python make.py DIR --many   some hundreds, of all sizes, depths, predictors and tables

Needs numpy, pydicom 3.0.2 and SimpleITK 2.5.7, whose GDCM decodes with libjpeg. The frames come from
the small encoder below. What is expected is what SimpleITK reads from a DICOM file around the frame,
and it must be the image that went in, less the bits that the point transform drops. SimpleITK takes
no image of less than 8 bits: there it is the image alone.
Each frame is NAME.ljpeg with NAME.raw (u16, little-endian), listed in index.txt:
name, rows, columns, bits.
"""

import pathlib
import struct
import sys
import tempfile

import numpy as np
import pydicom
import SimpleITK
from pydicom.dataset import FileDataset, FileMetaDataset
from pydicom.encaps import encapsulate

PREDICT = {
    1: lambda a, b, c: a,
    2: lambda a, b, c: b,
    3: lambda a, b, c: c,
    4: lambda a, b, c: a + b - c,
    5: lambda a, b, c: a + ((b - c) >> 1),
    6: lambda a, b, c: b + ((a - c) >> 1),
    7: lambda a, b, c: (a + b) >> 1,
}


def differences(x, bits, predictor, point, interval):
    """What is left of each sample when its prediction is taken off, -32 767 to 32 768."""
    x = x.astype(np.int64) >> point
    guess = np.zeros_like(x)
    guess[1:, 0] = x[:-1, 0]
    guess[1:, 1:] = PREDICT[predictor](x[1:, :-1], x[:-1, 1:], x[:-1, :-1])
    first = np.arange(len(x)) % (interval or len(x)) == 0
    guess[first, 1:] = x[first, :-1]
    guess[first, 0] = 1 << (bits - point - 1)
    d = (x - guess) & 0xFFFF
    return np.where(d > 32768, d - 65536, d)


def categories(d):
    return np.array([int(v).bit_length() for v in np.abs(d).ravel()]).reshape(d.shape)


def lengths_flat(_):
    return {c: 5 for c in range(17)}


def lengths_long(counts):
    """Codes of 1 to 14 bits and three of 16, the most frequent shortest."""
    order = sorted(range(17), key=lambda c: -counts[c])
    return {c: n for c, n in zip(order, [*range(1, 15), 16, 16, 16])}


def lengths_fit(counts):
    """Huffman's own lengths, with one code left for the bits that are all 1."""
    heap = [(n, [c]) for c, n in enumerate(counts) if n] + [(0, [])]
    length = {c: 0 for c, n in enumerate(counts) if n}
    while len(heap) > 1:
        heap.sort(key=lambda e: e[0])
        (n, first), (m, second) = heap[:2]
        for c in first + second:
            length[c] += 1
        heap = [*heap[2:], (n + m, first + second)]
    assert max(length.values()) <= 16
    return length


def codes(length):
    """Canonical codes: category to (code, bits); and the content of the DHT segment."""
    order = sorted(length, key=lambda c: (length[c], c))
    code, last, found = 0, 0, {}
    for c in order:
        code <<= length[c] - last
        found[c] = (code, length[c])
        code, last = code + 1, length[c]
    counts = [sum(n == bits for n in length.values()) for bits in range(1, 17)]
    return found, bytes([*counts, *order])


def pack(pairs):
    """(value, bits) after each other, filled with ones, a 0 after each FF."""
    text = "".join(format(v, f"0{n}b") for v, n in pairs if n)
    text += "1" * (-len(text) % 8)
    return int(text or "0", 2).to_bytes(len(text) // 8, "big").replace(b"\xff", b"\xff\0")


def segment(marker, content):
    return bytes([0xFF, marker]) + struct.pack(">H", len(content) + 2) + content


def encode(x, bits, predictor=1, point=0, interval=0, lengths=lengths_fit, extras=False):
    rows, cols = x.shape
    d = differences(x, bits, predictor, point, interval)
    s = categories(d)
    table, dht = codes(lengths(np.bincount(s.ravel(), minlength=17)))
    out = b"\xff\xd8"
    if extras:
        # A comment, fill bytes, another table in the same segment.
        out += segment(0xFE, b"filled") + b"\xff\xff"
        dht = b"\x01" + codes({c: 5 for c in range(17)})[1] + b"\0" + dht
    else:
        dht = b"\0" + dht
    out += segment(0xC3, struct.pack(">BHHB", bits, rows, cols, 1) + b"\1\x11\0")
    out += segment(0xC4, dht)
    if interval:
        out += segment(0xDD, struct.pack(">H", interval * cols))
    out += segment(0xDA, bytes([1, 1, 0, predictor, 0, point]))
    for n, top in enumerate(range(0, rows, interval or rows)):
        if n:
            out += bytes([0xFF] * (3 if extras else 1) + [0xD0 + (n - 1) % 8])
        part = slice(top, top + (interval or rows))
        pairs = []
        for v, c in zip(d[part].ravel().tolist(), s[part].ravel().tolist()):
            pairs.append(table[c])
            if c < 16:
                pairs.append((v if v > 0 else v + (1 << c) - 1, c))
        out += pack(pairs)
    return out + b"\xff\xd9"


def simpleitk(frame, shape, bits):
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = pydicom.uid.CTImageStorage
    meta.MediaStorageSOPInstanceUID = "1.2.3"
    meta.TransferSyntaxUID = pydicom.uid.JPEGLossless
    with tempfile.TemporaryDirectory() as folder:
        path = f"{folder}/frame.dcm"
        ds = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
        ds.SOPClassUID, ds.SOPInstanceUID, ds.Modality = meta.MediaStorageSOPClassUID, "1.2.3", "CT"
        ds.Rows, ds.Columns = shape
        ds.SamplesPerPixel, ds.PhotometricInterpretation = 1, "MONOCHROME2"
        ds.BitsAllocated, ds.BitsStored, ds.HighBit = 16, bits, bits - 1
        ds.PixelRepresentation = 0
        ds.PixelData = encapsulate([frame + b"\0" * (len(frame) % 2)])
        ds["PixelData"].VR = "OB"
        ds["PixelData"].is_undefined_length = True
        ds.save_as(path, enforce_file_format=True)
        return SimpleITK.GetArrayFromImage(SimpleITK.ReadImage(path)).reshape(shape)


def image(kind, rows, cols, bits, rng):
    j, i = np.mgrid[0:rows, 0:cols]
    top = (1 << bits) - 1
    if kind == "bell":
        r = ((i - cols / 2) / max(cols, 2)) ** 2 + ((j - rows / 2) / max(rows, 2)) ** 2
        x = top * np.exp(-6 * r) + rng.normal(0, top / 200, (rows, cols))
    elif kind == "noise":
        x = rng.integers(0, top, (rows, cols), endpoint=True)
    elif kind == "steps":
        x = ((i // 3 + j // 2) % 2) * (1 << (bits - 1))
    else:
        x = np.full((rows, cols), top // 3)
    return np.clip(np.rint(x), 0, top).astype(np.int64)


KEPT = {
    "first-12": ("bell", 24, 40, 12, {}),
    "first-16": ("noise", 12, 20, 16, {"lengths": lengths_flat}),
    "steps-16": ("steps", 12, 20, 16, {}),
    "short-2": ("noise", 9, 31, 2, {}),
    "short-7": ("bell", 24, 40, 7, {}),
    "short-8": ("bell", 24, 40, 8, {}),
    "long-codes-16": ("noise", 12, 20, 16, {"lengths": lengths_long}),
    "blank-12": ("flat", 24, 40, 12, {}),
    "one-12": ("bell", 1, 1, 12, {}),
    "row-12": ("bell", 1, 33, 12, {"predictor": 4}),
    "column-12": ("bell", 33, 1, 12, {"predictor": 7}),
    **{f"predictor-{p}": ("bell", 20, 33, 16, {"predictor": p}) for p in range(2, 8)},
    "point-2": ("bell", 24, 40, 12, {"point": 2}),
    "point-5-predictor-6": ("noise", 12, 20, 16, {"point": 5, "predictor": 6}),
    "restart-1": ("bell", 20, 33, 12, {"interval": 1}),
    "restart-2-fill": ("bell", 24, 40, 12, {"interval": 2, "predictor": 4, "extras": True}),
    "restart-5-point-1": ("bell", 24, 40, 12, {"interval": 5, "predictor": 5, "point": 1}),
}


def many(rng):
    for n in range(600):
        kind = str(rng.choice(["bell", "noise", "steps", "flat"]))
        rows, cols = (int(v) for v in rng.integers(1, 50, 2))
        bits = int(rng.integers(2, 17))
        how = {
            "predictor": int(rng.integers(1, 8)),
            "point": int(rng.integers(0, bits)) if rng.random() < 0.4 else 0,
            "interval": int(rng.integers(1, rows + 1)) if rng.random() < 0.5 else 0,
            "lengths": [lengths_fit, lengths_flat, lengths_long][int(rng.integers(3))],
            "extras": bool(rng.random() < 0.2),
        }
        yield f"many-{n:03}", (kind, rows, cols, bits, how)


def main():
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(14)
    frames = many(rng) if "--many" in sys.argv else KEPT.items()
    index = []
    for name, (kind, rows, cols, bits, how) in frames:
        x = image(kind, rows, cols, bits, rng)
        point = how.get("point", 0)
        wanted = x >> point << point
        frame = encode(x, bits, **how)
        if bits >= 8:
            read = simpleitk(frame, x.shape, bits)
            assert (read == wanted).all(), (name, how)
        (folder / f"{name}.ljpeg").write_bytes(frame)
        (folder / f"{name}.raw").write_bytes(wanted.astype("<u2").tobytes())
        index.append(f"{name} {rows} {cols} {bits}\n")
    (folder / "index.txt").write_text("".join(index))


main()
