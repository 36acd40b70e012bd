// What the preview uses of three.js: the bundle holds this and what it needs, nothing else.
export {
  Color,
  DirectionalLight,
  HemisphereLight,
  PerspectiveCamera,
  PropertyBinding,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
