// A frame's texture, laid in the frame's own coordinates by the shader of its material.
import * as THREE from 'three';
import shaderText from './solid_texture.glsl?raw';

/** In the order of PATTERN in solid_texture.glsl, from 1. */
const patterns = ['tortoiseshell', 'horn', 'pearl', 'carved'] as const;

/** As LOOK.json has it; any pattern that is not known here is plain. */
export interface SolidTexture {
  pattern: string;
  /** The pattern's own colour, linear light; the ground is the part's. */
  second: readonly number[];
  /** 0.1 … 10; 1 is a usual sheet. */
  scale: number;
  /** Which part of the sheet. */
  seed: number;
}

/** Three rows of four: from the station's coordinates (mm) to those in which textures lie. */
export type SolidPlace = readonly number[];

/** 0: plain. */
export function patternNumber(texture: SolidTexture | null): number {
  return texture ? patterns.findIndex((one) => one === texture.pattern) + 1 : 0;
}

/** What of a material follows a texture without a new shader. */
export class TextureUniforms {
  readonly #place = { value: new THREE.Matrix4() };
  readonly #second = { value: new THREE.Color() };
  readonly #scale = { value: 1 };
  readonly #seed = { value: 0 };

  set(texture: SolidTexture, place: SolidPlace): void {
    const rows = place.length === 12 ? place : [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
    this.#place.value.set(...([...rows, 0, 0, 0, 1] as Parameters<THREE.Matrix4['set']>));
    this.#second.value.setRGB(texture.second[0] ?? 0, texture.second[1] ?? 0, texture.second[2] ?? 0);
    this.#scale.value = texture.scale;
    this.#seed.value = texture.seed;
  }

  /** Puts the texture between a part's colour and its light. */
  addTo(shader: THREE.WebGLProgramParametersWithUniforms, pattern: number): void {
    Object.assign(shader.uniforms, { solidFromStation: this.#place, textureSecond: this.#second, textureScale: this.#scale, textureSeed: this.#seed });
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nuniform mat4 solidFromStation;\nvarying vec3 vSolid;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nvSolid = (solidFromStation * vec4(position, 1.0)).xyz;');
    const declared = `varying vec3 vSolid;\nuniform vec3 textureSecond;\nuniform float textureScale;\nuniform uint textureSeed;\n#define PATTERN ${pattern}\n${shaderText}`;
    // As long as two of the picture's pixels, and never finer than the true picture has it.
    const coloured = 'diffuseColor.rgb = textureColour(diffuseColor.rgb, textureSecond, vSolid, textureScale, textureSeed, max(0.6, 2.0 * length(fwidth(vSolid))));';
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\n${declared}`)
      .replace('#include <color_fragment>', `#include <color_fragment>\n${coloured}`);
  }
}
