"""A PNG file as numbers, from the PNG specification: 8 or 16 bits, grey, RGB or RGBA, not interlaced."""

import struct
import zlib

import numpy


def read_png(data):
    """The samples as an array (height, width, channels) of uint8 or uint16."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    position, header, packed = 8, None, b""
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position:position + 8])
        body = data[position + 8:position + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[position + 8 + length:position + 12 + length])[0]
        if kind == b"IHDR":
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        position += 12 + length
    width, height, depth, colour, _, _, interlace = header
    channels = {0: 1, 2: 3, 6: 4}[colour]
    assert depth in (8, 16) and interlace == 0
    pixel = channels * depth // 8
    stride = width * pixel
    raw = numpy.frombuffer(zlib.decompress(packed), numpy.uint8).reshape(height, stride + 1)
    rows, above = [], numpy.zeros(stride, numpy.int32)
    for line in raw:
        above = unfiltered(line[0], line[1:].astype(numpy.int32), above, pixel)
        rows.append(above)
    samples = numpy.array(rows, numpy.uint8).tobytes()
    return numpy.frombuffer(samples, ">u2" if depth == 16 else "u1").reshape(height, width, channels)


def unfiltered(kind, line, above, pixel):
    """One row without its filter (PNG specification, §9)."""
    if kind == 0:
        return line
    if kind == 2:
        return (line + above) & 255
    out = numpy.zeros_like(line)
    for k, value in enumerate(line):
        left = out[k - pixel] if k >= pixel else 0
        corner = above[k - pixel] if k >= pixel else 0
        if kind == 1:
            guess = left
        elif kind == 3:
            guess = (left + above[k]) // 2
        else:
            estimate = left + above[k] - corner
            distances = [abs(estimate - left), abs(estimate - above[k]), abs(estimate - corner)]
            guess = (left, above[k], corner)[distances.index(min(distances))]
        out[k] = (value + guess) & 255
    return out
