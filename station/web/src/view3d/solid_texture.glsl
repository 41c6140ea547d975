// The frame's textures (paper 000, §6.1) as render/texture.cpp has them, number for number: what is seen while a slider
// moves is the sheet of the true picture. PATTERN is 1 tortoiseshell, 2 horn, 3 pearl, 4 carved; GLSL ES 3.00.

uint hashOf(ivec3 at, uint channel) {
  uint h = channel;
  h ^= uint(at.x) * 0x8da6b343u;
  h ^= uint(at.y) * 0xd8163841u;
  h ^= uint(at.z) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  h = (h ^ (h >> 13)) * 0x297a2d39u;
  return h ^ (h >> 16);
}

float unitFrom(uint bits) { return float(bits & 0xffffu) * (1.0 / 65536.0); }

// The twelve edge directions of a cube, four of them twice.
const vec3 kGradients[16] = vec3[16](
  vec3(1, 1, 0), vec3(-1, 1, 0), vec3(1, -1, 0), vec3(-1, -1, 0), vec3(1, 0, 1), vec3(-1, 0, 1), vec3(1, 0, -1), vec3(-1, 0, -1),
  vec3(0, 1, 1), vec3(0, -1, 1), vec3(0, 1, -1), vec3(0, -1, -1), vec3(1, 1, 0), vec3(-1, 1, 0), vec3(0, -1, 1), vec3(0, -1, -1));

float corner(ivec3 at, vec3 inside, ivec3 of, uint channel) {
  return dot(kGradients[hashOf(at + of, channel) & 15u], inside - vec3(of));
}

// Gradient noise of wavelength about 1, within -1 ... 1.
float noise(vec3 p, uint channel) {
  vec3 low = floor(p);
  ivec3 at = ivec3(low);
  vec3 f = p - low;
  vec3 t = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  float near = mix(mix(corner(at, f, ivec3(0, 0, 0), channel), corner(at, f, ivec3(1, 0, 0), channel), t.x),
                   mix(corner(at, f, ivec3(0, 1, 0), channel), corner(at, f, ivec3(1, 1, 0), channel), t.x), t.y);
  float far = mix(mix(corner(at, f, ivec3(0, 0, 1), channel), corner(at, f, ivec3(1, 0, 1), channel), t.x),
                  mix(corner(at, f, ivec3(0, 1, 1), channel), corner(at, f, ivec3(1, 1, 1), channel), t.x), t.y);
  return clamp(mix(near, far, t.z), -1.0, 1.0);
}

// What is left of a wave (mm) of which pixels can show no shorter one than `shortest`.
float resolved(float wave, float scale, float shortest) { return smoothstep(shortest, 2.0 * shortest, wave * scale); }

// Two dyes as they mix in a melt.
vec3 dyeMix(vec3 from, vec3 to, float share) {
  const float trace = 1.0e-6;
  vec3 a = from + trace;
  vec3 b = to + trace;
  vec3 mixed = sqrt(a * b * mix(a, b, share) / mix(b, a, share)) - trace;
  return clamp(mixed, min(from, to), max(from, to));
}

vec3 tortoiseshell(vec3 ground, vec3 second, vec3 p, float scale, uint seed, float shortest) {
  vec3 q = p * vec3(0.8, 0.55, 1.0);
  float wide = noise(q / 13.0, seed + 1u);
  float middle = noise(q / 6.1, seed + 2u);
  float small = resolved(2.6, scale, shortest) * noise(q / 2.6, seed + 3u);
  float cloud = wide + 0.55 * middle + 0.12 * small;
  float haze = 0.36 * smoothstep(-0.40, 0.25, cloud - 0.25 * middle);
  return dyeMix(ground, second, max(haze, smoothstep(-0.02, 0.28, cloud)));
}

vec3 horn(vec3 ground, vec3 second, vec3 p, float scale, uint seed, float shortest) {
  vec3 slow = p / 34.0;
  float height = p.z + 9.0 * noise(slow, seed + 11u);
  float bands = noise(vec3(slow.xy, height / 9.0), seed + 12u);
  float streaks = noise(vec3(p.xy / 26.0, height / 2.7), seed + 13u);
  float fine = resolved(1.3, scale, shortest) * noise(vec3(p.xy / 14.0, height / 1.3), seed + 14u);
  return dyeMix(ground, second, smoothstep(-0.55, 0.65, 0.8 * bands + 0.75 * streaks + 0.35 * fine));
}

vec3 pearl(vec3 ground, vec3 second, vec3 p, uint seed) {
  uint channel = seed + 21u;
  float swirl = noise(p / 9.0, channel);
  vec3 q = vec3(p.x / 5.2 + 0.8 * swirl, p.y / 7.0, p.z / 3.6 - 0.6 * swirl) - 0.5;
  vec3 low = floor(q);
  vec3 inside = q - low;
  const float gap = 0.02;
  float sum = 0.5 * gap;
  float weights = gap;
  for (int k = 0; k < 8; ++k) {
    ivec3 of = ivec3(k & 1, (k >> 1) & 1, k >> 2);
    uint h = hashOf(ivec3(low) + of, channel);
    uint g = h * 0x85ebca6bu;
    vec3 centre = vec3(of) + 0.5 * vec3(unitFrom(h), unitFrom(h >> 8), unitFrom(h >> 16)) - 0.25;
    vec3 from = inside - centre;
    float near = max(0.0, 1.0 - dot(from, from) / 0.5625);
    float weight = near * near * near;
    sum += weight * (unitFrom(g >> 6) + 1.3 * ((unitFrom(g) - 0.5) * from.x + (unitFrom(g >> 12) - 0.5) * from.z));
    weights += weight;
  }
  return mix(ground, second, smoothstep(-0.1, 1.15, sum / weights));
}

float ridge(float phase) {
  float t = fract(phase);
  float bell = 4.0 * t * (1.0 - t);
  return bell * bell;
}

vec3 carved(vec3 ground, vec3 second, vec3 p, float scale, uint seed, float shortest) {
  const float period = 1.8;
  float wave = 0.9 * noise(p / 11.0, seed + 31u);
  float along = 0.72 * (p.x - p.y);
  float lines = ridge((along + p.z) / period + wave);
  float crossing = ridge((along - p.z) / period - wave);
  float cut = 0.68 * lines + 0.32 * lines * crossing;
  return mix(ground, second, mix(0.45, cut, resolved(period, scale, shortest)));
}

// The colour at `solid` (mm, the frame's own coordinates); `shortest`: the shortest wave that pixels can show, mm.
vec3 textureColour(vec3 ground, vec3 second, vec3 solid, float scale, uint seed, float shortest) {
  vec3 p = solid / scale;
  uint part = seed * 0x9e3779b9u;
#if PATTERN == 1
  return tortoiseshell(ground, second, p, scale, part, shortest);
#elif PATTERN == 2
  return horn(ground, second, p, scale, part, shortest);
#elif PATTERN == 3
  return pearl(ground, second, p, part);
#else
  return carved(ground, second, p, scale, part, shortest);
#endif
}
