// A GLB before and after `seamwright unwrap`, drawn by three.js in headless Chromium, its skin posed.
//
//     cd FOLDER_WITH_NODE_MODULES   # npm i three
//     node .../tests/bench/gltf_picture.mjs BEFORE.glb AFTER.glb OUT.png [SECONDS]
//
// Three views: before, after, and after with a checkerboard on the new UVs. Where the file has an animation it stands at SECONDS;
// where it has none, every second bone of its skins is bent by 0.4. Needs `chromium` on the path. Prints how many pixels of the
// first two views differ by more than 2 of 255: none where the materials have no textures on the UVs that were written.
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import path from 'node:path';

const [before, after, out, seconds = '0.5'] = process.argv.slice(2);
const page = `<!doctype html><body style="margin:0;background:#fff"><script type="importmap">{"imports":{"three":"/node_modules/three/build/three.module.js",
"three/addons/":"/node_modules/three/examples/jsm/"}}</script><script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
const side = 480;
const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(side, side);
const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
const board = document.createElement('canvas');
board.width = board.height = 512;
const pen = board.getContext('2d');
for (let y = 0; y < 32; y++) for (let x = 0; x < 32; x++) { pen.fillStyle = (x + y) % 2 ? '#fff' : 'hsl(' + (x * 11) + ' 70% ' + (25 + y) + '%)'; pen.fillRect(x * 16, y * 16, 16, 16); }
const checker = new THREE.CanvasTexture(board);
checker.flipY = false;
checker.colorSpace = THREE.SRGBColorSpace;
async function view(url, checked) {
  const gltf = await loader.loadAsync(url);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(checked ? 0xf4f4f0 : 0xe8ecf2);
  scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, 0x556677, 2.5));
  const sun = new THREE.DirectionalLight(0xffffff, 2);
  sun.position.set(2, 3, 4);
  scene.add(sun);
  let bones = 0;
  if (gltf.animations.length) {
    const mixer = new THREE.AnimationMixer(gltf.scene);
    mixer.clipAction(gltf.animations[0]).play();
    mixer.setTime(${Number(seconds)});
  } else {
    gltf.scene.traverse((node) => { if (node.isBone && bones++ % 2) node.rotation.z += 0.4; });
  }
  gltf.scene.updateMatrixWorld(true);
  if (checked) gltf.scene.traverse((node) => { if (node.isMesh) node.material = new THREE.MeshStandardMaterial({ map: checker, roughness: 0.9, side: THREE.DoubleSide }); });
  const box = new THREE.Box3().setFromObject(gltf.scene, true);
  const centre = box.getCenter(new THREE.Vector3());
  const size = box.getSize(new THREE.Vector3()).length();
  const camera = new THREE.PerspectiveCamera(35, 1, size / 100, size * 10);
  camera.position.copy(centre).add(new THREE.Vector3(0.7, 0.45, 0.9).normalize().multiplyScalar(size * 1.7));
  camera.lookAt(centre);
  renderer.render(scene, camera);
  const gl = renderer.getContext();
  const pixels = new Uint8Array(side * side * 4);
  gl.readPixels(0, 0, side, side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const image = new Image();
  image.src = renderer.domElement.toDataURL();
  await image.decode();
  document.body.append(image);
  return pixels;
}
try {
  const [a, b] = [await view('/before', false), await view('/after', false)];
  await view('/after', true);
  let count = 0;
  for (let i = 0; i < a.length; i += 4) if ([0, 1, 2].some((k) => Math.abs(a[i + k] - b[i + k]) > 2)) count += 1;
  document.title = 'differing pixels: ' + count + ' of ' + a.length / 4;
} catch (e) { document.title = 'failed: ' + e.stack; }
await fetch('/title', { method: 'POST', body: document.title });
</script>`;

let title = 'no answer';
const server = http.createServer((request, response) => {
  const send = (bytes, kind) => response.writeHead(200, { 'content-type': kind }).end(bytes);
  if (request.url === '/') return send(page, 'text/html');
  if (request.url === '/before') return send(fs.readFileSync(before), 'model/gltf-binary');
  if (request.url === '/after') return send(fs.readFileSync(after), 'model/gltf-binary');
  if (request.url === '/title') { request.on('data', (text) => { title = String(text); }); request.on('end', () => response.end()); return; }
  const file = path.join(process.cwd(), decodeURIComponent(request.url.split('?')[0]));
  if (!file.startsWith(path.join(process.cwd(), 'node_modules')) || !fs.existsSync(file)) return response.writeHead(404).end();
  send(fs.readFileSync(file), file.endsWith('.js') ? 'text/javascript' : 'application/octet-stream');
});
server.listen(0, '127.0.0.1', () => {
  const { port } = server.address();
  const flags = ['--headless=new', '--no-sandbox', '--disable-gpu-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--hide-scrollbars', '--window-size=1440,484', '--virtual-time-budget=60000', `--screenshot=${path.resolve(out)}`, `http://127.0.0.1:${port}/`];
  const browser = spawn('chromium', flags, { stdio: 'ignore' });
  browser.on('exit', () => { console.log(`${out}: ${title}`); server.close(); process.exit(title.startsWith('differing') ? 0 : 1); });
});
