// How surfaces look: neutral, lit with the camera, and honest about what was not measured.
import * as THREE from 'three';
import type { PartKind } from './mesh_format';
import { TextureUniforms, type SolidPlace, type SolidTexture } from './solid_texture';

const knowledgeVertex = { declare: 'attribute float knowledge;\nvarying float vKnowledge;', set: 'vKnowledge = knowledge;' };

// Inferred: paler, with thin diagonal lines that keep their width on the screen. Unknown: bare, a flat sieve that
// nobody takes for skin. The lines are laid in picture space, where they cannot alias.
const knowledgeFragment = `
  float lineOfScreen = fract((gl_FragCoord.x + gl_FragCoord.y) / hatchPixels);
  if (vKnowledge > 1.5) {
    vec2 cell = fract(gl_FragCoord.xy / hatchPixels) - 0.5;
    if (dot(cell, cell) > 0.07) discard;
    diffuseColor.rgb = unknownColour;
  } else if (vKnowledge > 0.5) {
    diffuseColor.rgb = mix(diffuseColor.rgb, vec3(1.0), 0.35) * (lineOfScreen < 0.22 ? 0.72 : 1.0);
  }`;

export interface SurfaceMaterial {
  material: THREE.MeshLambertMaterial | THREE.MeshPhongMaterial;
  setColour(colour: readonly [number, number, number, number]): void;
  /** Pixels of the drawing buffer per CSS pixel, so that the hatching keeps its size. */
  setPixelRatio(ratio: number): void;
  /** Of a material that was made with a pattern. */
  setTexture(texture: SolidTexture, place: SolidPlace): void;
}

/** A material for a part; `knowledge` marks what was inferred and what is unknown; `pattern`: patternNumber(). */
export function makeSurfaceMaterial(kind: PartKind, knowledge: boolean, pattern = 0): SurfaceMaterial {
  const shiny = kind === 'frame' || kind === 'lens';
  const material = shiny
    ? new THREE.MeshPhongMaterial({ side: THREE.DoubleSide, specular: 0x555555, shininess: kind === 'lens' ? 90 : 45 })
    : new THREE.MeshLambertMaterial({ side: THREE.DoubleSide });
  if (kind === 'lens') {
    material.transparent = true;
    material.depthWrite = false;
  } else {
    // Lines drawn on the surface win against it.
    material.polygonOffset = true;
    material.polygonOffsetFactor = 1;
    material.polygonOffsetUnits = 1;
  }
  const hatch = { value: 7 };
  if (knowledge) {
    const unknownColour = { value: new THREE.Color(0x8a8f98) };
    material.onBeforeCompile = (shader) => {
      shader.uniforms['hatchPixels'] = hatch;
      shader.uniforms['unknownColour'] = unknownColour;
      shader.vertexShader = shader.vertexShader
        .replace('#include <common>', `#include <common>\n${knowledgeVertex.declare}`)
        .replace('#include <begin_vertex>', `#include <begin_vertex>\n${knowledgeVertex.set}`);
      shader.fragmentShader = shader.fragmentShader
        .replace('#include <common>', '#include <common>\nvarying float vKnowledge;\nuniform float hatchPixels;\nuniform vec3 unknownColour;')
        .replace('#include <color_fragment>', `#include <color_fragment>\n${knowledgeFragment}`);
    };
    material.customProgramCacheKey = () => 'knowledge';
  }
  const texture = new TextureUniforms();
  if (pattern > 0) {
    material.onBeforeCompile = (shader) => texture.addTo(shader, pattern);
    material.customProgramCacheKey = () => `texture ${pattern}`;
  }
  return {
    material,
    setColour: ([r, g, b, a]) => {
      material.color.setRGB(r, g, b);
      material.opacity = a;
      // Translucent plastic is blended but keeps its depth, so that a temple does not show its own back.
      if (kind !== 'lens') material.transparent = a < 1;
    },
    setPixelRatio: (ratio) => {
      hatch.value = 7 * ratio;
    },
    setTexture: (one, place) => texture.set(one, place),
  };
}
