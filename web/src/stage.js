// The canvas: one camera, one pane a result.

import { AmbientLight, Color, DirectionalLight, HemisphereLight, OrthographicCamera, Scene, Vector3, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';

/** Names, keys and directions from the face to the eye; +x is the subject's left. */
export const VIEWS = [
  { name: 'Front', from: [0, 0, 1] },
  { name: 'Right three-quarter', from: [-0.7, 0.12, 0.72] },
  { name: 'Left three-quarter', from: [0.7, 0.12, 0.72] },
  { name: 'Right profile', from: [-1, 0, 0] },
  { name: 'Left profile', from: [1, 0, 0] },
  { name: 'From inside', from: [0, 0, -1] },
];

export class Stage {
  constructor(canvas, drawn, changed) {
    Object.assign(this, { canvas, drawn, changed });
    // The buffer is kept so that the page can be printed and the picture saved.
    this.renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.camera = new OrthographicCamera();
    this.scenes = drawn.map((d) => {
      const scene = new Scene();
      const lights = [new AmbientLight(0xffffff), new HemisphereLight(0xffffff, 0x9a8f88), new DirectionalLight(0xfff6ee)];
      scene.add(d.group, ...lights, lights[2].target);
      scene.userData.lights = lights;
      return scene;
    });
    this.light(false);
    this.shown = drawn.map(() => true);
    const lo = [0, 1, 2].map((c) => Math.min(...drawn.map((d) => d.face.box.lo[c])));
    const hi = [0, 1, 2].map((c) => Math.max(...drawn.map((d) => d.face.box.hi[c])));
    this.centre = new Vector3(...lo.map((x, c) => (x + hi[c]) / 2));
    this.half = lo.map((x, c) => (hi[c] - x) / 2);
    this.distance = 4 * Math.max(...this.half);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.target.copy(this.centre);
    this.orbit.enableDamping = false;
    this.orbit.minZoom = 0.4;
    this.orbit.maxZoom = 12;
    this.orbit.addEventListener('change', () => this.changed());
    this.look(0);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  /** Lights the face as a body, or `evenly`, so that its colours can be read off. */
  light(evenly) {
    const strengths = evenly ? [1.75, 0.7, 0.9] : [0.75, 1.0, 1.8];
    for (const { userData } of this.scenes) userData.lights.forEach((light, k) => (light.intensity = strengths[k]));
  }

  get panes() {
    return this.scenes.filter((_, k) => this.shown[k]);
  }

  /** Looks from the `k`-th of the views, the whole face in the pane. */
  look(k) {
    this.view = k;
    this.camera.zoom = 1;
    this.orbit.target.copy(this.centre);
    const [x, , z] = VIEWS[k].from.map(Math.abs);
    this.halfWidth = (z * this.half[0] + x * this.half[2]) / Math.hypot(x, z);
    this.camera.position.set(...VIEWS[k].from).normalize().multiplyScalar(this.distance).add(this.centre);
    this.resize();
    this.orbit.update();
    this.changed();
  }

  /** Turns about the face by degrees to the right and up. */
  turn(right, up) {
    const arm = this.camera.position.clone().sub(this.orbit.target);
    const length = arm.length(), degree = Math.PI / 180;
    const azimuth = Math.atan2(arm.x, arm.z) + right * degree;
    const height = Math.min(Math.max(Math.asin(arm.y / length) + up * degree, -1.5), 1.5);
    const flat = length * Math.cos(height);
    arm.set(flat * Math.sin(azimuth), length * Math.sin(height), flat * Math.cos(azimuth));
    this.camera.position.copy(arm.add(this.orbit.target));
    this.orbit.update();
    this.changed();
  }

  magnify(factor) {
    this.camera.zoom = Math.min(Math.max(this.camera.zoom * factor, this.orbit.minZoom), this.orbit.maxZoom);
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.size = [clientWidth, clientHeight];
    this.renderer.setSize(clientWidth, clientHeight, false);
    const aspect = clientWidth / this.panes.length / clientHeight;
    const half = 1.1 * Math.max(this.half[1], this.halfWidth / aspect);
    const { camera } = this;
    [camera.left, camera.right, camera.top, camera.bottom] = [-half * aspect, half * aspect, half, -half];
    [camera.near, camera.far] = [0.1, 3 * this.distance];
    this.halfHeight = half;
    camera.updateProjectionMatrix();
    this.changed();
  }

  /** Pixels of the page to the millimetre. */
  get pixelsPerMm() {
    return (this.size[1] / (2 * this.halfHeight)) * this.camera.zoom;
  }

  render() {
    const { renderer, camera, panes, size } = this;
    const background = new Color(getComputedStyle(document.documentElement).getPropertyValue('--stage').trim());
    renderer.setScissorTest(true);
    const width = size[0] / panes.length;
    const eye = camera.position.clone().sub(this.orbit.target);
    panes.forEach((scene, k) => {
      const lamp = scene.userData.lights[2];
      // The light stands above the viewer's left shoulder and goes along.
      lamp.position.copy(eye).applyAxisAngle(new Vector3(0, 1, 0), -0.4).add(new Vector3(0, 0.5 * eye.length(), 0)).add(this.centre);
      lamp.target.position.copy(this.centre);
      scene.background = background;
      renderer.setViewport(k * width, 0, width, size[1]);
      renderer.setScissor(k * width, 0, width, size[1]);
      renderer.render(scene, camera);
    });
  }

  /** What lies at the left and at the right end of the picture, in words; none where it is seen at a slant. */
  ends() {
    const right = new Vector3(1, 0, 0).applyQuaternion(this.camera.quaternion);
    if (Math.abs(right.x) > 0.85) return right.x > 0 ? ['subject’s right', 'subject’s left'] : ['subject’s left', 'subject’s right'];
    if (Math.abs(right.z) > 0.85) return right.z > 0 ? ['back', 'front'] : ['front', 'back'];
    return ['', ''];
  }
}
