// The page in headless Chromium, from its folder: drops a mesh on it, waits, saves. node web_page.js CHROMIUM MESH.obj FOLDER
// leaves FOLDER/page.obj, what the page saved, and FOLDER/page.png, how it looked. Speaks the browser's own protocol over a
// pipe, so nothing needs to be installed.
'use strict';
const { spawn } = require('child_process');
const { mkdtempSync, readFileSync, renameSync, rmSync, writeFileSync, existsSync } = require('fs');
const { tmpdir } = require('os');
const { basename, join, resolve } = require('path');

const LIMIT = 300e3; // milliseconds for all of it
const [chromium, mesh, folder] = process.argv.slice(2);
const profile = mkdtempSync(join(tmpdir(), 'seamwright-page-'));
const browser = spawn(
    chromium,
    ['--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--remote-debugging-pipe',
        `--user-data-dir=${profile}`, '--window-size=1280,1000'],
    { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] },
);
const [, , , to, from] = browser.stdio;
const waiting = new Map();
let last = 0, rest = '';
from.on('data', (data) => {
    const messages = (rest + data).split('\0');
    rest = messages.pop();
    for (const { id, result, error } of messages.map(JSON.parse)) {
        const [resolve, reject] = waiting.get(id) || [() => {}, () => {}];
        if (error) reject(new Error(error.message));
        else resolve(result);
    }
});
let sessionId;
const call = (method, params = {}) => new Promise((resolve, reject) => {
    waiting.set(++last, [resolve, reject]);
    to.write(JSON.stringify({ id: last, method, params, sessionId }) + '\0');
});
const evaluate = async (expression) => {
    const { result, exceptionDetails } = await call('Runtime.evaluate', { expression, awaitPromise: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description || exceptionDetails.text);
    return result.value;
};
const until = async (what, holds) => {
    for (const start = Date.now(); Date.now() - start < LIMIT;) {
        const found = await holds();
        if (found) return found;
        await new Promise((done) => setTimeout(done, 100));
    }
    throw new Error(`${what}: not within ${LIMIT / 1000} s`);
};

async function main() {
    await call('Browser.setDownloadBehavior', { behavior: 'allow', downloadPath: resolve(folder) });
    const page = `file://${resolve(__dirname, '../docs/web/index.html')}`;
    const { targetId } = await call('Target.createTarget', { url: page });
    ({ sessionId } = await call('Target.attachToTarget', { targetId, flatten: true }));
    await until('the page', () => evaluate(`document.readyState === 'complete' && typeof Pictures === 'object'`));
    await evaluate(`{
        const bytes = Uint8Array.from(atob('${readFileSync(mesh, 'base64')}'), (c) => c.charCodeAt(0));
        const dataTransfer = new DataTransfer();
        dataTransfer.items.add(new File([bytes], ${JSON.stringify(basename(mesh))}));
        document.getElementById('drop').dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }`);
    const said = () => evaluate(`document.getElementById('said').textContent`);
    await until('the atlas', async () => {
        if (await evaluate(`document.getElementById('said').className`)) throw new Error(await said());
        return evaluate(`!document.getElementById('save').disabled`);
    });
    console.log(`chromium: ${await said()}`);
    const isCut = !/ 1 charts/.test(await said()); // one chart of an open mesh may have no seam
    for (const id of ['mesh', 'atlas']) {
        // Seams are drawn in one red that no chart has.
        const [drawn, red] = JSON.parse(await evaluate(`{
            const canvas = document.getElementById('${id}');
            const pixels = new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer);
            JSON.stringify([pixels.filter((p) => p).length, pixels.filter((p) => p === 0xff0000cc).length]);
        }`));
        if (!drawn || (isCut && !red)) throw new Error(`${id}: ${drawn} pixels are drawn, ${red} of them seams`);
    }
    const { data } = await call('Page.captureScreenshot');
    writeFileSync(join(folder, 'page.png'), Buffer.from(data, 'base64'));
    await evaluate(`document.getElementById('save').click()`);
    const saved = join(folder, basename(mesh).replace(/\.obj$/, '_uv.obj'));
    await until('the saved OBJ', () => existsSync(saved));
    renameSync(saved, join(folder, 'page.obj'));
}

main()
    .catch((error) => {
        console.error(`page: ${error.message}`);
        process.exitCode = 1;
    })
    .finally(() => {
        browser.once('exit', () => rmSync(profile, { recursive: true, force: true, maxRetries: 3 }));
        browser.kill();
    });
