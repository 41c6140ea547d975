// The picture of a body or a head in the station frame (mm; z up, front +y): surfaces, lines, marks and a camera.
// It draws only when something has changed, and gives back everything on dispose().
import * as THREE from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { h } from '../core/dom';
import type { StationMesh } from './mesh_format';
import { boundsOf } from './mesh_format';
import { pickMesh, type MeshHit, type Ray, type Vec3 } from './mesh_pick';
import { attachOrbit, between, eyeOf, views, type CameraPlace, type ViewName } from './orbit';
import { Overlay, type Mark } from './overlay';
import { patternNumber, type SolidPlace, type SolidTexture } from './solid_texture';
import { makeSurfaceMaterial, type SurfaceMaterial } from './surface_material';
import './viewer.css';

export type { CameraPlace, ViewName } from './orbit';
export type { MeshHit, Ray, Vec3 } from './mesh_pick';

export interface ViewerOptions {
  /** What the picture shows, for those who do not see it. */
  label: string;
  /** Shown instead if the browser has no WebGL. */
  unavailable: string;
}

export interface LayerStyle {
  /** Instead of what the mesh says, by part kind: linear light and opacity, 0 … 1. */
  colour?: { body?: [number, number, number, number] };
  /** Inferred hatched and paler, unknown bare. */
  knowledge?: boolean;
  /** Of the mesh's parts, in their order (instead of `knowledge`), and where they lie. */
  textures?: { parts: readonly (SolidTexture | null)[]; place: SolidPlace };
}

export interface LineStyle {
  /** CSS colour and width in CSS pixels. */
  colour: string;
  width_px: number;
  /** Also drawn, faintly, where the body hides it. */
  through?: boolean;
}

interface Layer {
  mesh: StationMesh;
  object: THREE.Mesh;
  materials: Map<string, SurfaceMaterial>;
}

const fieldOfView_deg = 28;
/** While something moves, a picture that takes longer (ms) is drawn with fewer pixels. */
const slowFrame_ms = 45;
const coarseRatio = 0.6;
/** Where smooth edges cost too much, a picture that has stood for a moment is drawn once more with this many pixels. */
const fineRatio = 2;
const standing_ms = 350;
const glide_ms = 250;

export class Viewer {
  /** The element that was put into the host; it takes the keyboard. */
  readonly element: HTMLElement;
  /** False if the browser has no WebGL; everything else then does nothing. */
  readonly available: boolean;
  /** Asked at every press: true keeps the camera still (the page drags something). */
  claim: (event: PointerEvent) => boolean = () => false;

  readonly #renderer: THREE.WebGLRenderer | null;
  readonly #software: boolean;
  readonly #scene = new THREE.Scene();
  readonly #camera = new THREE.PerspectiveCamera(fieldOfView_deg, 1, 10, 30_000);
  readonly #lamp = new THREE.DirectionalLight(0xffffff, 2.3);
  readonly #overlay = new Overlay();
  readonly #layers = new Map<string, Layer>();
  readonly #lines = new Map<string, Line2[]>();
  readonly #cameraListeners = new Set<(place: CameraPlace) => void>();
  readonly #ends: (() => void)[] = [];
  #place: CameraPlace = { azimuth_deg: views.front, elevation_deg: 0, distance_mm: 4000, target: [0, 0, 900] };
  #frame = 0;
  #fineTimer = 0;
  #ratioAfterFine: number | null = null;
  #drawn = 0;
  #moving = false;
  #lastFrame_ms = 0;
  #frameTime_ms = 16;
  #glide: { from: CameraPlace; to: CameraPlace; start_ms: number } | null = null;

  constructor(host: HTMLElement, options: ViewerOptions) {
    this.element = h('div', { class: 'view3d', tabindex: '0', role: 'application', 'aria-label': options.label });
    this.#software = drawsInSoftware();
    this.#renderer = makeRenderer(!this.#software);
    this.available = this.#renderer !== null;
    host.append(this.element);
    if (!this.#renderer) {
      this.element.append(h('p', { class: 'view3d-missing' }, options.unavailable));
      return;
    }
    this.element.append(this.#renderer.domElement, this.#overlay.element);
    this.#camera.up.set(0, 0, 1);
    this.#lamp.position.set(-0.7, 0.8, 1);
    this.#camera.add(this.#lamp);
    this.#scene.add(this.#camera, new THREE.HemisphereLight(0xffffff, 0xa39c95, 0.95));
    this.#watchHost(this.#renderer);
    this.#ends.push(
      attachOrbit({
        element: this.element,
        place: () => this.#place,
        setPlace: (place) => this.setCamera(place),
        mmPerPixel: () => this.mmPerPixel(),
        claims: (event) => this.claim(event),
        moving: (now) => this.#setMoving(now),
      }),
    );
    this.#resize();
  }

  /** Pictures drawn so far. */
  get drawn(): number {
    return this.#drawn;
  }

  // Surfaces

  /** Puts, changes or (null) takes away a surface. Cheap enough for 30 changes a second of 20,000 triangles. */
  setMesh(name: string, mesh: StationMesh | null, style: LayerStyle = {}): void {
    const old = this.#layers.get(name);
    if (!mesh) {
      if (old) this.#dropLayer(name, old);
    } else {
      // Materials stay: a new one would have its shader compiled again.
      const materials = old?.materials ?? new Map<string, SurfaceMaterial>();
      const object = old?.object ?? new THREE.Mesh();
      object.geometry.dispose();
      object.geometry = geometryOf(mesh);
      object.material = mesh.parts.map((part, i) => {
        const texture = style.textures?.parts[i] ?? null;
        const pattern = patternNumber(texture);
        const key = `${i} ${part.kind} ${style.knowledge === true} ${pattern}`;
        const surface = materials.get(key) ?? makeSurfaceMaterial(part.kind, style.knowledge === true, pattern);
        materials.set(key, surface);
        if (texture && style.textures) surface.setTexture(texture, style.textures.place);
        surface.setColour((part.kind === 'body' && style.colour?.body) || part.colour);
        surface.setPixelRatio(this.#renderer?.getPixelRatio() ?? 1);
        return surface.material;
      });
      if (!old) this.#scene.add(object);
      this.#layers.set(name, { mesh, object, materials });
    }
    this.requestRender();
  }

  showMesh(name: string, shown: boolean): void {
    const layer = this.#layers.get(name);
    if (layer) layer.object.visible = shown;
    this.requestRender();
  }

  /** Anything else of three.js, in mm of the station frame. Who adds it disposes of its geometry and material. */
  add(object: THREE.Object3D): void {
    this.#scene.add(object);
    this.requestRender();
  }

  remove(object: THREE.Object3D): void {
    this.#scene.remove(object);
    this.requestRender();
  }

  // Lines and marks

  /** Puts, changes or (null) takes away a line through places (mm). */
  setLine(name: string, points: readonly Vec3[] | null, style: LineStyle = { colour: '#0b62d6', width_px: 3 }): void {
    for (const line of this.#lines.get(name) ?? []) {
      this.#scene.remove(line);
      line.geometry.dispose();
      line.material.dispose();
    }
    this.#lines.delete(name);
    if (points && points.length > 1) {
      const lines = makeLines(points, style, this.#size());
      this.#scene.add(...lines);
      this.#lines.set(name, lines);
    }
    this.requestRender();
  }

  /** Puts, changes or (null) takes away a label or handle. */
  setMark(id: string, mark: Mark | null): void {
    this.#overlay.set(id, mark);
    this.requestRender();
  }

  /** A label of plain text beside a place. */
  setLabel(id: string, position: Vec3 | null, text = '', normal?: Vec3): void {
    this.setMark(id, position && { position, kind: 'label', element: h('span', null, text), ...(normal && { normal }) });
  }

  marks(): string[] {
    return this.#overlay.ids();
  }

  /** Takes away all lines and marks whose names begin so. */
  clear(prefix: string): void {
    for (const name of [...this.#lines.keys()]) if (name.startsWith(prefix)) this.setLine(name, null);
    for (const id of this.#overlay.ids()) if (id.startsWith(prefix)) this.setMark(id, null);
  }

  // Camera

  camera(): CameraPlace {
    return this.#place;
  }

  /** Puts the camera somewhere; listeners hear of it unless `quiet` (two linked pictures would answer each other). */
  setCamera(place: CameraPlace, how: 'told' | 'quiet' = 'told'): void {
    this.#glide = null;
    this.#put(place, how);
  }

  /** Calls whenever the camera moves; what is returned ends it. */
  onCamera(listener: (place: CameraPlace) => void): () => void {
    this.#cameraListeners.add(listener);
    return () => this.#cameraListeners.delete(listener);
  }

  /** Glides to a named view. */
  view(name: ViewName): void {
    this.glideTo({ ...this.#place, azimuth_deg: views[name], elevation_deg: 0 });
  }

  glideTo(place: CameraPlace): void {
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) return this.setCamera(place);
    this.#glide = { from: this.#place, to: place, start_ms: performance.now() };
    this.requestRender();
  }

  /** Looks at a place from a distance at which `height_mm` there fill the picture's height. */
  lookAt(target: Vec3, height_mm: number): void {
    this.setCamera({ ...this.#place, target, distance_mm: height_mm / (2 * Math.tan((fieldOfView_deg * Math.PI) / 360)) });
  }

  /** Steps back until all surfaces (or one) are in the picture. */
  frame(layer?: string): void {
    const box = new THREE.Box3();
    for (const [name, { mesh }] of this.#layers) {
      const bounds = layer === undefined || layer === name ? boundsOf(mesh) : null;
      if (bounds) box.expandByPoint(new THREE.Vector3(...bounds.low)).expandByPoint(new THREE.Vector3(...bounds.high));
    }
    if (box.isEmpty()) return;
    const centre = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const half = Math.tan((fieldOfView_deg * Math.PI) / 360);
    const across = Math.max(size.x, size.y);
    const distance = Math.max(size.z / 2 / half, across / 2 / (half * this.#camera.aspect)) * 1.06 + across / 2;
    this.setCamera({ ...this.#place, target: centre.toArray(), distance_mm: distance });
  }

  /** mm across the picture per CSS pixel, at the distance of what is looked at. */
  mmPerPixel(): number {
    return (2 * this.#place.distance_mm * Math.tan((fieldOfView_deg * Math.PI) / 360)) / Math.max(1, this.element.clientHeight);
  }

  /** The ray through a place of the window (clientX, clientY). */
  rayAt(clientX: number, clientY: number): Ray {
    const box = this.element.getBoundingClientRect();
    const x = (2 * (clientX - box.left)) / Math.max(1, box.width) - 1;
    const y = 1 - (2 * (clientY - box.top)) / Math.max(1, box.height);
    this.#aim();
    const origin = this.#camera.position.toArray();
    const direction = new THREE.Vector3(x, y, 0.5).unproject(this.#camera).sub(this.#camera.position).normalize().toArray();
    return { origin, direction };
  }

  /** What of a surface is seen at a place of the window; null for none. */
  pick(layer: string, clientX: number, clientY: number): MeshHit | null {
    const found = this.#layers.get(layer);
    return found ? pickMesh(found.mesh, this.rayAt(clientX, clientY)) : null;
  }

  /** Where a place appears: CSS pixels from the element's upper left corner; null behind the camera. */
  project(position: Vec3): { x: number; y: number } | null {
    const p = new THREE.Vector3(...position).project(this.#camera);
    if (p.z > 1) return null;
    return { x: ((p.x + 1) / 2) * this.element.clientWidth, y: ((1 - p.y) / 2) * this.element.clientHeight };
  }

  // Drawing

  requestRender(): void {
    if (this.#frame === 0 && this.#renderer) this.#frame = requestAnimationFrame((now) => this.#draw(now));
  }

  /** Ends the picture: GPU memory, listeners and the element are given back. */
  dispose(): void {
    cancelAnimationFrame(this.#frame);
    window.clearTimeout(this.#fineTimer);
    this.#frame = -1;
    for (const end of this.#ends.splice(0)) end();
    for (const [name, layer] of [...this.#layers]) this.#dropLayer(name, layer);
    for (const name of [...this.#lines.keys()]) this.setLine(name, null);
    this.#cameraListeners.clear();
    this.#renderer?.dispose();
    this.#renderer?.forceContextLoss();
    this.element.remove();
  }

  #draw(now_ms: number): void {
    this.#frame = 0;
    const renderer = this.#renderer;
    if (!renderer || this.element.clientWidth === 0) return;
    this.#stepGlide(now_ms);
    this.#keepFluent(renderer, now_ms);
    this.#aim();
    renderer.render(this.#scene, this.#camera);
    this.#overlay.place((p) => this.project(p), eyeOf(this.#place), this.element.clientWidth, this.element.clientHeight);
    // For whoever measures how fluent it is from outside.
    renderer.domElement.dataset['triangles'] = String(renderer.info.render.triangles);
    renderer.domElement.dataset['drawn'] = String(++this.#drawn);
    this.#drawFineLater(renderer);
  }

  /**
   * A picture that stands gets all its pixels; where WebGL does not smooth edges, more than those, which smooths them.
   */
  #drawFineLater(renderer: THREE.WebGLRenderer): void {
    window.clearTimeout(this.#fineTimer);
    const rest = this.#software ? fineRatio : this.#fullRatio();
    const ratio = renderer.getPixelRatio();
    if (this.#moving || this.#glide || ratio === rest) return;
    this.#fineTimer = window.setTimeout(() => {
      this.#setPixelRatio(renderer, rest);
      this.#aim();
      renderer.render(this.#scene, this.#camera);
      // The next picture is an ordinary one again; changing the size now would clear this one.
      this.#ratioAfterFine = this.#software ? Math.min(ratio, this.#fullRatio()) : null;
    }, standing_ms);
  }

  #stepGlide(now_ms: number): void {
    if (!this.#glide) return;
    const share = Math.min(1, Math.max(0, now_ms - this.#glide.start_ms) / glide_ms);
    this.#put(between(this.#glide.from, this.#glide.to, share * share * (3 - 2 * share)), 'told');
    if (share === 1) this.#glide = null;
    else this.requestRender();
  }

  /** Fewer pixels while something moves, where the machine draws slowly; all of them once it stands. */
  #keepFluent(renderer: THREE.WebGLRenderer, now_ms: number): void {
    const passed = now_ms - this.#lastFrame_ms;
    const busy = this.#moving || this.#glide !== null || passed < standing_ms;
    this.#lastFrame_ms = now_ms;
    if (busy && passed < 1000) this.#frameTime_ms += 0.3 * (passed - this.#frameTime_ms);
    const full = this.#fullRatio();
    if (this.#ratioAfterFine !== null) this.#setPixelRatio(renderer, this.#ratioAfterFine);
    this.#ratioAfterFine = null;
    const ratio = busy && this.#frameTime_ms > slowFrame_ms ? full * coarseRatio : busy ? renderer.getPixelRatio() : full;
    if (ratio !== renderer.getPixelRatio()) this.#setPixelRatio(renderer, ratio);
  }

  /** At most twice the screen's own; drawn on the processor, no more than CSS pixels. */
  #fullRatio(): number {
    return Math.min(window.devicePixelRatio, this.#software ? 1 : 2);
  }

  #setPixelRatio(renderer: THREE.WebGLRenderer, ratio: number): void {
    renderer.setPixelRatio(ratio);
    for (const layer of this.#layers.values()) for (const surface of layer.materials.values()) surface.setPixelRatio(ratio);
  }

  #aim(): void {
    const [x, y, z] = eyeOf(this.#place);
    this.#camera.position.set(x, y, z);
    this.#camera.near = Math.max(5, this.#place.distance_mm / 50);
    this.#camera.far = this.#place.distance_mm + 6000;
    this.#camera.updateProjectionMatrix();
    this.#camera.lookAt(...this.#place.target);
    this.#camera.updateMatrixWorld();
  }

  #put(place: CameraPlace, how: 'told' | 'quiet'): void {
    this.#place = place;
    this.requestRender();
    if (how === 'told') for (const listener of [...this.#cameraListeners]) listener(place);
  }

  #setMoving(now: boolean): void {
    this.#moving = now;
    this.requestRender();
  }

  #size(): THREE.Vector2 {
    return new THREE.Vector2(this.element.clientWidth, this.element.clientHeight);
  }

  #resize(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!this.#renderer || width === 0 || height === 0) return;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / height;
    for (const line of [...this.#lines.values()].flat()) line.material.resolution.set(width, height);
    this.requestRender();
  }

  #watchHost(renderer: THREE.WebGLRenderer): void {
    this.#setPixelRatio(renderer, this.#fullRatio());
    const colour = (): void => {
      renderer.setClearColor(new THREE.Color(getComputedStyle(this.element).backgroundColor));
      this.requestRender();
    };
    // The style sheet may come after the element; the first size comes after both.
    const sizes = new ResizeObserver(() => {
      colour();
      this.#resize();
    });
    sizes.observe(this.element);
    const theme = new MutationObserver(colour);
    theme.observe(document.documentElement, { attributes: true });
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', colour);
    // After a lost context three.js builds everything anew by itself; what is missing is somebody who draws.
    const restored = (): void => this.requestRender();
    renderer.domElement.addEventListener('webglcontextrestored', restored);
    this.#ends.push(
      () => sizes.disconnect(),
      () => theme.disconnect(),
      () => dark.removeEventListener('change', colour),
      () => renderer.domElement.removeEventListener('webglcontextrestored', restored),
    );
  }

  #dropLayer(name: string, layer: Layer): void {
    this.#scene.remove(layer.object);
    layer.object.geometry.dispose();
    for (const { material } of layer.materials.values()) material.dispose();
    this.#layers.delete(name);
  }
}

/** Whether WebGL runs on the processor, where smooth edges and more pixels than the screen's cost too much. */
let software: boolean | null = null;
function drawsInSoftware(): boolean {
  if (software !== null) return software;
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl?.getExtension('WEBGL_debug_renderer_info');
  const name = gl && names ? String(gl.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return (software = /swiftshader|llvmpipe|softpipe|basic render/i.test(name));
}

function makeRenderer(antialias: boolean): THREE.WebGLRenderer | null {
  try {
    return new THREE.WebGLRenderer({ antialias, alpha: false, powerPreference: 'high-performance' });
  } catch {
    return null;
  }
}

function geometryOf(mesh: StationMesh): THREE.BufferGeometry {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(mesh.positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(mesh.normals, 3));
  geometry.setAttribute('knowledge', new THREE.BufferAttribute(mesh.knowledge, 1));
  geometry.setIndex(new THREE.BufferAttribute(mesh.indices, 1));
  mesh.parts.forEach((part, i) => geometry.addGroup(part.firstIndex, part.count, i));
  return geometry;
}

function makeLines(points: readonly Vec3[], style: LineStyle, size: THREE.Vector2): Line2[] {
  const make = (hidden: boolean): Line2 => {
    const material = new LineMaterial({ color: new THREE.Color(style.colour).getHex(), linewidth: style.width_px });
    material.resolution.copy(size);
    if (hidden) {
      material.depthFunc = THREE.GreaterDepth;
      material.depthWrite = false;
      material.transparent = true;
      material.opacity = 0.3;
    }
    const line = new Line2(new LineGeometry().setPositions(points.flat()), material);
    line.frustumCulled = false;
    return line;
  };
  return style.through ? [make(false), make(true)] : [make(false)];
}
