"""Makes blank-2912.j2k: a square of 1000 in 2912 rows and columns of 0, lossless JPEG 2000, 16 bits.

Needs numpy, pydicom 3.0.2 and SimpleITK 2.5.7, whose GDCM encodes with OpenJPEG.
"""

import pathlib
import tempfile

import numpy as np
import pydicom
import SimpleITK

image = np.zeros((2912, 2912), np.uint16)
image[1000:1800, 1000:1800] = 1000
with tempfile.TemporaryDirectory() as folder:
    writer = SimpleITK.ImageFileWriter()
    writer.SetImageIO("GDCMImageIO")
    writer.UseCompressionOn()
    writer.SetCompressor("JPEG2000")
    writer.SetFileName(f"{folder}/image.dcm")
    writer.Execute(SimpleITK.GetImageFromArray(image))
    pixels = pydicom.dcmread(f"{folder}/image.dcm").PixelData
frame = pydicom.encaps.get_frame(pixels, 0, number_of_frames=1)
pathlib.Path(__file__).with_name("blank-2912.j2k").write_bytes(frame)
