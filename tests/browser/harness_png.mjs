// Pictures made small and compared: a page that looks otherwise is found, another smoothing of letters is not.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { deflateSync, inflateSync } from 'node:zlib';

/** Cells of a reference. */
const kColumns = 128;
const kRows = 96;
/** Of 255: mean difference of all cells, and how far off a single one counts as different. */
const kMostMean = 5;
const kCellOff = 40;
const kMostCellsOff = 0.02;

/** 8-bit RGB or RGBA, not interlaced: what a browser writes. */
export function decodePng(bytes) {
  if (bytes.readUInt32BE(0) !== 0x89504e47) throw new Error('not a PNG');
  const parts = [];
  let header = null;
  for (let at = 8; at < bytes.length; ) {
    const length = bytes.readUInt32BE(at);
    const kind = bytes.toString('latin1', at + 4, at + 8);
    const data = bytes.subarray(at + 8, at + 8 + length);
    if (kind === 'IHDR') header = { width: data.readUInt32BE(0), height: data.readUInt32BE(4), depth: data[8], colour: data[9], interlaced: data[12] };
    if (kind === 'IDAT') parts.push(data);
    at += 12 + length;
  }
  const channels = { 2: 3, 6: 4 }[header?.colour];
  if (!channels || header.depth !== 8 || header.interlaced) throw new Error('a kind of PNG that is not read here');
  return { width: header.width, height: header.height, channels, pixels: unfilter(inflateSync(Buffer.concat(parts)), header.width * channels, header.height, channels) };
}

function unfilter(raw, stride, rows, channels) {
  const out = Buffer.alloc(stride * rows);
  for (let y = 0; y < rows; y += 1) {
    const filter = raw[y * (stride + 1)];
    for (let x = 0; x < stride; x += 1) {
      const left = x >= channels ? out[y * stride + x - channels] : 0;
      const up = y > 0 ? out[(y - 1) * stride + x] : 0;
      const corner = x >= channels && y > 0 ? out[(y - 1) * stride + x - channels] : 0;
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
      out[y * stride + x] = (raw[y * (stride + 1) + 1 + x] + guess) & 255;
    }
  }
  return out;
}

function paeth(left, up, corner) {
  const [a, b, c] = [Math.abs(up - corner), Math.abs(left - corner), Math.abs(left + up - 2 * corner)];
  return a <= b && a <= c ? left : b <= c ? up : corner;
}

function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; bit += 1) crc = (crc >>> 1) ^ (0xedb88320 & -(crc & 1));
  }
  return (crc ^ 0xffffffff) >>> 0;
}

function encodePng(pixels, width, height) {
  const raw = Buffer.alloc((width * 3 + 1) * height);
  for (let y = 0; y < height; y += 1) pixels.copy(raw, y * (width * 3 + 1) + 1, y * width * 3, (y + 1) * width * 3);
  const chunk = (kind, data) => {
    const body = Buffer.concat([Buffer.from(kind, 'latin1'), data]);
    const out = Buffer.alloc(body.length + 8);
    out.writeUInt32BE(data.length, 0);
    body.copy(out, 4);
    out.writeUInt32BE(crc32(body), body.length + 4);
    return out;
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk('IHDR', header), chunk('IDAT', deflateSync(raw)), chunk('IEND', Buffer.alloc(0))]);
}

/** Means over cells: RGB, kColumns × kRows. */
function shrink({ width, height, channels, pixels }) {
  const out = Buffer.alloc(kColumns * kRows * 3);
  for (let row = 0; row < kRows; row += 1) {
    const [top, bottom] = [Math.floor((row * height) / kRows), Math.floor(((row + 1) * height) / kRows)];
    for (let column = 0; column < kColumns; column += 1) {
      const [left, right] = [Math.floor((column * width) / kColumns), Math.floor(((column + 1) * width) / kColumns)];
      const sum = [0, 0, 0];
      for (let y = top; y < bottom; y += 1) {
        for (let x = left; x < right; x += 1) for (let c = 0; c < 3; c += 1) sum[c] += pixels[(y * width + x) * channels + c];
      }
      const count = (bottom - top) * (right - left);
      for (let c = 0; c < 3; c += 1) out[(row * kColumns + column) * 3 + c] = Math.round(sum[c] / count);
    }
  }
  return out;
}

/**
 * Fails if a screenshot looks otherwise than its reference, of which a small copy is then at `seenFile`. With
 * ANNULUS_UPDATE_REFERENCES set the reference is written instead; where there is none yet it is said, and nothing compared.
 */
export function compareWithReference(screenshot, referenceFile, seenFile) {
  const seen = shrink(decodePng(screenshot));
  if (process.env.ANNULUS_UPDATE_REFERENCES) return writeFileSync(referenceFile, encodePng(seen, kColumns, kRows));
  if (!existsSync(referenceFile)) return console.log(`       not compared, there is no reference yet: ${referenceFile} (ANNULUS_UPDATE_REFERENCES=1 makes it)`);
  const reference = decodePng(readFileSync(referenceFile)).pixels;
  let sum = 0;
  let off = 0;
  for (let cell = 0; cell < kColumns * kRows; cell += 1) {
    const apart = Math.max(...[0, 1, 2].map((c) => Math.abs(seen[3 * cell + c] - reference[3 * cell + c])));
    sum += apart;
    off += apart > kCellOff ? 1 : 0;
  }
  const mean = sum / (kColumns * kRows);
  const share = off / (kColumns * kRows);
  if (mean <= kMostMean && share <= kMostCellsOff) return;
  writeFileSync(seenFile, encodePng(seen, kColumns, kRows));
  throw new Error(`the page looks otherwise than ${referenceFile}: mean ${mean.toFixed(1)} (at most ${kMostMean}), ${(100 * share).toFixed(1)} % of the cells (at most ${100 * kMostCellsOff} %); see ${seenFile}`);
}
