// SPDX-License-Identifier: BSD-3-Clause
// The camera and what moves it: pan, zoom at the pointer and, in 3D, rotation. Zoom is in pixels per metre.
"use strict";

const kSlowFrame = 50; // ms
const kFastFrame = 40; // ms
const kLeastShare = 0.01;
const kRest = 200; // ms without a move
const kZoomKeys = { "+": 1.25, "=": 1.25, "-": 0.8 };

class View {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.dimension = scene.dimension;
    this.box = boxOf(scene);
    this.radius = Math.max(this.box.getSize(new THREE.Vector3()).length() / 2, 0.5);
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.world = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 40 * this.radius);
    this.camera.up.set(0, this.dimension === 2 ? 1 : 0, this.dimension === 2 ? 0 : 1);
    this.onDraw = [];
    this.share = 1;
    this.makeControls();
    this.resize();
    this.fit();
    window.addEventListener("resize", () => this.resize());
  }

  makeControls() {
    const controls = new THREE.OrbitControls(this.camera, this.canvas);
    controls.screenSpacePanning = true;
    controls.enableRotate = this.dimension === 3;
    controls.zoomSpeed = 1.6;
    controls.keyPanSpeed = 40; // pixels
    if (this.dimension === 2) {
      controls.mouseButtons = { LEFT: THREE.MOUSE.PAN, MIDDLE: THREE.MOUSE.DOLLY, RIGHT: THREE.MOUSE.PAN };
      controls.touches = { ONE: THREE.TOUCH.PAN, TWO: THREE.TOUCH.DOLLY_PAN };
    }
    controls.addEventListener("change", () => this.move());
    this.controls = controls;
    // Keeps what is under the pointer there: the controls zoom about the middle, and this listener comes after theirs.
    this.canvas.addEventListener("wheel", (event) => this.keepUnder(event.clientX, event.clientY));
    this.canvas.addEventListener("keydown", ({ key, altKey, ctrlKey, metaKey }) => {
      if (key in kZoomKeys && !altKey && !ctrlKey && !metaKey) this.zoomBy(kZoomKeys[key]);
    });
  }

  /// Zooms about the middle of what the panel leaves free.
  zoomBy(factor) {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.keepUnder((window.innerWidth + this.panelWidth()) / 2, window.innerHeight / 2);
  }

  keepUnder(x, y) {
    const { camera } = this;
    const by = 1 / this.lastZoom - 1 / camera.zoom;
    const shift = new THREE.Vector3(x - window.innerWidth / 2, window.innerHeight / 2 - y, 0).multiplyScalar(by);
    shift.applyQuaternion(camera.quaternion);
    camera.position.add(shift);
    this.controls.target.add(shift);
    this.lastZoom = camera.zoom;
    this.controls.update();
    this.draw();
  }

  resize() {
    const { innerWidth: width, innerHeight: height } = window;
    this.renderer.setSize(width, height, false);
    Object.assign(this.camera, { left: -width / 2, right: width / 2, top: height / 2, bottom: -height / 2 });
    this.camera.updateProjectionMatrix();
    this.world.traverse((object) => {
      if (object.material && object.material.resolution) object.material.resolution.set(width, height);
    });
    this.draw();
  }

  /// Shows a box, by default that of the whole scene, beside the panel.
  fit(box = this.box) {
    const width = window.innerWidth - this.panelWidth();
    const centre = box.getCenter(new THREE.Vector3());
    const size = box.getSize(new THREE.Vector3());
    const away = this.dimension === 2 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(-0.5, -0.9, 0.6).normalize();
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(away, 15 * this.radius);
    const across = this.dimension === 2 ? size.x : size.length();
    const up = this.dimension === 2 ? size.y : 0.8 * size.length();
    this.camera.zoom = 0.88 * Math.min(width / Math.max(across, 1e-3), window.innerHeight / Math.max(up, 1e-3));
    this.camera.updateProjectionMatrix();
    this.lookBeside();
  }

  /// Brings a point to the middle of what the panel leaves free.
  centre(point) {
    this.camera.position.add(point).sub(this.controls.target);
    this.controls.target.copy(point);
    this.lookBeside();
  }

  /// Moves what is in the middle of the page to the middle of what the panel leaves free.
  lookBeside() {
    this.controls.update();
    const shift = new THREE.Vector3(-this.panelWidth() / 2 / this.camera.zoom, 0, 0).applyQuaternion(this.camera.quaternion);
    this.camera.position.add(shift);
    this.controls.target.add(shift);
    this.controls.update();
    this.lastZoom = this.camera.zoom;
    this.stand();
  }

  /// The width that the panel takes from the left of the page (pixels); 0 if it takes half of the page, and lies over the map.
  panelWidth() {
    const panel = document.getElementById("panel").getBoundingClientRect();
    return panel.width < 0.5 * window.innerWidth ? panel.right : 0;
  }

  /// A function that projects place k of an array to pixels of the page and a depth.
  projector() {
    this.camera.updateMatrixWorld();
    const { elements: e } = new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse);
    const halfWidth = window.innerWidth / 2;
    const halfHeight = window.innerHeight / 2;
    return (places, k, out) => {
      const x = places[3 * k];
      const y = places[3 * k + 1];
      const z = places[3 * k + 2];
      out.x = halfWidth * (1 + e[0] * x + e[4] * y + e[8] * z + e[12]);
      out.y = halfHeight * (1 - (e[1] * x + e[5] * y + e[9] * z + e[13]));
      out.depth = e[2] * x + e[6] * y + e[10] * z + e[14];
    };
  }

  /// Draws after the camera has moved: while it moves, as much of large layers as leaves the motion smooth; all of them once it
  /// rests.
  move() {
    this.isMoving = true;
    clearTimeout(this.rest);
    this.rest = setTimeout(() => this.stand(), kRest);
    this.draw();
  }

  stand() {
    clearTimeout(this.rest);
    this.isMoving = false;
    this.draw();
  }

  /// Adapts the share that is drawn in motion to the time that the last frame took (ms).
  adapt(taken) {
    if (taken > kSlowFrame) this.share = Math.max(kLeastShare, this.share * Math.max(0.2, (0.7 * kSlowFrame) / taken));
    if (taken < kFastFrame) this.share = Math.min(1, 1.2 * this.share);
  }

  /// Draws soon, and once for however many calls.
  draw() {
    if (this.isDrawing) return;
    this.isDrawing = true;
    requestAnimationFrame(() => this.drawNow());
  }

  drawNow() {
    this.isDrawing = false;
    for (const listener of this.onDraw) listener();
    drawShare(this.world, this.isMoving ? this.share : 1);
    const begin = performance.now();
    this.renderer.render(this.world, this.camera);
    if (this.isMoving) requestAnimationFrame(() => this.adapt(performance.now() - begin));
  }
}

/// The box around maps and their truth, without odometry alone, which can be anywhere.
function boxOf(scene) {
  const box = new THREE.Box3();
  const point = new THREE.Vector3();
  const hold = (places) => {
    for (let k = 0; k + 2 < places.length; k += 3) {
      if (!Number.isNaN(places[k])) box.expandByPoint(point.fromArray(places, k));
    }
  };
  for (const map of scene.maps) [map.poses, map.features].forEach(hold);
  if (scene.truth) [scene.truth.poses, scene.truth.features].forEach(hold);
  return box;
}

/// The largest number of 1, 2 or 5 times a power of ten that is at most `most`.
function roundBelow(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].map((factor) => factor * power).find((round) => round <= most * (1 + 1e-12)) || power;
}

/// Makes the scale bar of a round length, at most an eighth of the page or, if that is more, 120 pixels.
function updateScaleBar(view) {
  const metres = roundBelow(Math.max(120, window.innerWidth / 8) / view.camera.zoom);
  document.getElementById("scale-bar").style.width = `${metres * view.camera.zoom}px`;
  document.getElementById("scale-text").textContent =
    metres >= 1000 ? `${metres / 1000} km` : metres >= 1 ? `${metres} m` : `${+(metres * 100).toPrecision(1)} cm`;
}
