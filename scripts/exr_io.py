"""Read and write EXR images as named float32 channels, through Mitsuba's Bitmap.

A Mitsuba variant must be set before any function here is called.
Images are arrays of shape (height, width); row 0 is the top row.
"""

import mitsuba as mi
import numpy as np


def read_exr(path):
    """Return the channels of an EXR file as a dict of name -> float32 array."""
    bitmap = mi.Bitmap(str(path))
    pixels = np.array(bitmap, dtype=np.float32)
    pixels = pixels.reshape(pixels.shape[0], pixels.shape[1], -1)
    names = [field.name for field in bitmap.struct_()]
    return {name: pixels[..., i] for i, name in enumerate(names)}


def write_exr(path, channels):
    """Write a dict of channel name -> array as a zip-compressed float32 EXR file."""
    pixels = np.stack([np.asarray(c, dtype=np.float32) for c in channels.values()], axis=-1)
    layout = mi.Bitmap.PixelFormat.MultiChannel
    mi.Bitmap(pixels, layout, list(channels)).write(str(path))
