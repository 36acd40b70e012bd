// A face of a glTF file, turned by hand and moved frame by frame: at the file's own keys, never between.

import {
  Color, DirectionalLight, GLTFLoader, HemisphereLight, OrbitControls, PerspectiveCamera, PropertyBinding, Scene,
  Vector3, WebGLRenderer,
} from "./vendor/three.js";

const LIGHTS = [ // where from, in the face's frame; colour; strength
  [[-0.5, 0.62, 0.9], 0xfff1e2, 2.2],
  [[0.9, 0.1, 0.6], 0xdfe8ff, 0.8],
  [[0.5, 0.7, -1], 0xe6edff, 0.8],
];
const SKY = [0xf2f4fa, 0x6b5c52, 1.05];
const NEAREST = 0.3, FARTHEST = 2.2; // of the distance from which the whole head is seen
const MOST_PIXELS = 2; // per CSS pixel

export const VIEWS = { front: 0, three: 40, side: 90 }; // degrees about the head

export class Face {
  /** canvas, context: where it is drawn, see contextOf. box: the head's middle, half its height and the camera's distance in
   * such halves. turned: told when a person turned it. */
  constructor(canvas, context, { middle, half, distance }, turned) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, context });
    this.scene = new Scene();
    this.scene.add(new HemisphereLight(...SKY));
    for (const [from, colour, strength] of LIGHTS) {
      const light = new DirectionalLight(new Color(colour), strength);
      light.position.set(...from);
      this.scene.add(light);
    }
    this.middle = new Vector3(...middle);
    this.away = distance * half;
    this.opening = Math.atan(1 / distance); // half the angle that shows the head
    this.camera = new PerspectiveCamera(30, 1, this.away / 50, this.away * 10);
    this.controls = new OrbitControls(this.camera, canvas);
    Object.assign(this.controls, {
      enablePan: false, minDistance: NEAREST * this.away, maxDistance: FARTHEST * this.away,
      minPolarAngle: 0.35, maxPolarAngle: Math.PI - 0.35,
    });
    this.look(0);
    this.controls.addEventListener("change", () => {
      this.draw();
      if (!this.following) turned();
    });
    this.seen = new ResizeObserver(() => this.#fit());
    this.seen.observe(canvas.parentElement);
  }

  /** Take a file's bytes in place of what is shown. fps, frames: of the motion that it holds. */
  async set(bytes, fps, frames) {
    this.wanted = bytes;
    const gltf = await new GLTFLoader().parseAsync(bytes, "");
    if (this.wanted !== bytes) return; // something else was, meanwhile
    if (this.model) this.scene.remove(this.model);
    this.#forget();
    this.model = gltf.scene;
    this.meshes = [];
    this.model.traverse((one) => {
      if (!one.isMesh) return;
      one.frustumCulled = false; // it moves out of the box that it rests in
      this.meshes.push(one);
    });
    const [{ tracks }] = gltf.animations;
    this.times = tracks[0].times;
    this.parts = tracks.map((track) => ({ track, part: PropertyBinding.create(this.model, track.name) }));
    this.keys = keysOf(this.times, fps, frames);
    this.scene.add(this.model);
    this.key = null;
  }

  /** Show the motion at a frame; one that has no key, as not tracked, shows the one before it. */
  show(frame) {
    if (!this.model || this.key === this.keys[frame]) return;
    this.key = this.keys[frame];
    for (const { track, part } of this.parts) part.setValue(track.values, this.key * track.getValueSize());
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  /** From so many degrees to the right of the front, as far away as shows the whole head. */
  look(degrees) {
    const angle = (degrees * Math.PI) / 180;
    this.camera.position.copy(this.middle);
    this.camera.position.x += this.away * Math.sin(angle);
    this.camera.position.z += this.away * Math.cos(angle);
    this.controls.target.copy(this.middle);
    this.controls.update();
  }

  /** A step nearer (below 1) or away. */
  zoom(by) {
    this.camera.position.sub(this.middle).multiplyScalar(by).add(this.middle);
    this.controls.update();
  }

  /** Look from where another one is looked at. */
  follow(other) {
    this.following = true;
    this.camera.position.copy(other.camera.position);
    this.controls.target.copy(other.controls.target);
    this.controls.update();
    this.following = false;
  }

  get names() {
    return Object.keys(this.meshes[0].morphTargetDictionary);
  }

  /** Where a vertex is drawn: its morph targets added, its joints turned. */
  vertex(number) {
    this.model.updateMatrixWorld(true);
    const [mesh] = this.meshes;
    return mesh.getVertexPosition(number, new Vector3()).applyMatrix4(mesh.matrixWorld).toArray();
  }

  #forget() {
    for (const mesh of this.meshes ?? []) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
  }

  /** The head fits into the picture's shorter edge. */
  #fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, MOST_PIXELS));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    const half = Math.atan(Math.tan(this.opening) * Math.max(1, height / width));
    this.camera.fov = (2 * half * 180) / Math.PI;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}

/** What a face is drawn with; null where the browser does not draw. */
export const contextOf = (canvas) => canvas.getContext("webgl2", { alpha: true, antialias: true, premultipliedAlpha: true });

/** For each frame, its key or the last one before it; before the first key, that. */
function keysOf(times, fps, frames) {
  const keys = new Int32Array(frames);
  let key = 0;
  for (let frame = 0; frame < frames; frame += 1) {
    while (key + 1 < times.length && Math.round(times[key + 1] * fps) <= frame) key += 1;
    keys[frame] = key;
  }
  return keys;
}

/** The bytes of an answer. heard(part): how much of it is there, 0 to 1. Throws what the server says. */
export async function bytesOf(path, heard) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(await answer.text());
  const size = Number(answer.headers.get("Content-Length"));
  const bytes = new Uint8Array(size);
  let got = 0;
  for (const reader = answer.body.getReader();;) {
    const { done, value } = await reader.read();
    if (done) return bytes.buffer;
    bytes.set(value, got);
    got += value.length;
    heard(got / size);
  }
}
