// The shader that shows a frame's texture while a slider moves, against the colours of the true picture's textures.
import { readFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, test } from './harness.mjs';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
const patterns = ['tortoiseshell', 'horn', 'pearl', 'carved'];
/** Of a channel's whole range: what sums in another order and single precision may differ by. */
const kTolerance = 1e-4;

/** Draws one pixel for each place (a texel of a float texture); answers their colours. In the page. */
function drawPlaces({ shader, places, ground, second, scale, seed }) {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl.getExtension('EXT_color_buffer_float')) throw new Error('this browser draws no float pixels');
  const program = gl.createProgram();
  for (const [kind, text] of [
    [gl.VERTEX_SHADER, '#version 300 es\nin vec2 at;\nvoid main() { gl_Position = vec4(at, 0.0, 1.0); }'],
    [gl.FRAGMENT_SHADER, `#version 300 es\nprecision highp float;\nprecision highp int;\nprecision highp sampler2D;\n${shader}
      uniform sampler2D places;\nuniform vec3 ground, second;\nuniform float scale;\nuniform uint seed;\nout vec4 colour;
      void main() { colour = vec4(textureColour(ground, second, texelFetch(places, ivec2(gl_FragCoord.xy), 0).xyz, scale, seed, 0.6), 1.0); }`],
  ]) {
    const one = gl.createShader(kind);
    gl.shaderSource(one, text);
    gl.compileShader(one);
    if (!gl.getShaderParameter(one, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(one));
    gl.attachShader(program, one);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  const floats = (data) => {
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, places.length, 1, 0, gl.RGBA, gl.FLOAT, data);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return gl.getParameter(gl.TEXTURE_BINDING_2D);
  };
  const target = floats(null);
  floats(new Float32Array(places.flatMap((place) => [...place, 1])));
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
  gl.viewport(0, 0, places.length, 1);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array([-1, -1, 3, -1, -1, 3]), gl.STATIC_DRAW);
  gl.enableVertexAttribArray(0);
  gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
  const at = (name) => gl.getUniformLocation(program, name);
  gl.uniform3fv(at('ground'), ground);
  gl.uniform3fv(at('second'), second);
  gl.uniform1f(at('scale'), scale);
  gl.uniform1ui(at('seed'), seed);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const pixels = new Float32Array(4 * places.length);
  gl.readPixels(0, 0, places.length, 1, gl.RGBA, gl.FLOAT, pixels);
  return places.map((_, k) => [...pixels.slice(4 * k, 4 * k + 3)]);
}

test('the preview’s textures have the colours of the true picture’s', async (browser) => {
  const stored = JSON.parse(readFileSync(join(root, 'tests/golden/texture_colours.json'), 'utf8'));
  const text = readFileSync(join(root, 'station/web/src/view3d/solid_texture.glsl'), 'utf8');
  const page = await browser.newPage();
  let worst = 0;
  try {
    for (const { pattern, second, scale, seed, colours } of stored.textures) {
      const shader = `#define PATTERN ${patterns.indexOf(pattern) + 1}\n${text}`;
      const seen = await page.evaluate(drawPlaces, { shader, places: stored.places_mm, ground: stored.ground, second, scale, seed });
      seen.forEach((colour, k) => colour.forEach((value, channel) => {
        const off = Math.abs(value - colours[k][channel]);
        expect(off <= kTolerance, `${pattern}, scale ${scale}, seed ${seed}, place ${stored.places_mm[k]}: seen ${colour}, wanted ${colours[k]}`);
        worst = Math.max(worst, off);
      }));
    }
  } finally {
    await page.close();
  }
  console.log(`       largest difference ${worst.toExponential(1)} [${kTolerance}]`);
});
