// The page: a file in, pictures and a file out. The work is done in a worker, whose text is that of seamwright.js, so that
// the page works from a folder as it does from a server.
'use strict';

(() => {
    const element = (id) => document.getElementById(id);
    const state = { name: '', obj: null, result: null, seams: null, worker: null, turn: 0.6, tilt: -0.4 };

    function say(text, isBad = false) {
        element('said').textContent = text;
        element('said').className = isBad ? 'bad' : '';
    }

    function asked() {
        const values = new FormData(element('asked'));
        return Object.fromEntries([...values].map(([name, value]) => [name, Number(value)]));
    }

    // A worker that answers { result } or { error } to { module, mesh, asked }.
    function startWorker() {
        const listen = () => {
            onmessage = ({ data: { module, mesh, asked } }) => {
                try {
                    postMessage({ result: seamwright(module).unwrap(mesh, asked) });
                } catch (error) {
                    postMessage({ error: error.message });
                }
            };
        };
        const text = `${seamwright}\n(${listen})()`;
        const address = URL.createObjectURL(new Blob([text], { type: 'text/javascript' }));
        const worker = new Worker(address);
        URL.revokeObjectURL(address);
        return worker;
    }

    function stop() {
        if (state.worker) state.worker.terminate();
        state.worker = null;
        element('stop').disabled = true;
    }

    function unwrap() {
        if (!state.obj) return say('Drop an OBJ first.', true);
        if (typeof MODULE === 'undefined') return say('module.js is missing: run .ci/wasm to build it.', true);
        stop();
        element('save').disabled = true;
        element('stop').disabled = false;
        const { positions, corners, starts } = state.obj, start = performance.now();
        say(`${state.name}: unwrapping ${starts.length - 1} polygons ...`);
        state.worker = startWorker();
        state.worker.onmessage = ({ data: { result, error } }) => {
            stop();
            if (error) return say(`${state.name}: ${error}`, true);
            const seconds = ((performance.now() - start) / 1000).toFixed(1);
            state.result = result;
            state.seams = Pictures.seams(state.obj, result.uv);
            draw();
            element('save').disabled = false;
            const percent = (100 * result.utilisation).toFixed(1);
            say(`${state.name}: ${result.charts} charts, distortion ${result.distortion.toFixed(4)}, ` +
                `${percent} % of the square used, ${seconds} s`);
        };
        state.worker.onerror = (event) => {
            stop();
            say(`${state.name}: ${event.message}`, true);
        };
        const module = Uint8Array.from(atob(MODULE), (character) => character.charCodeAt(0));
        state.worker.postMessage({ module, mesh: { positions, corners, starts }, asked: asked() });
    }

    function draw() {
        if (!state.result) return;
        const { obj, result, seams, turn, tilt } = state;
        Pictures.atlas(element('atlas'), obj, result, seams);
        Pictures.surface(element('mesh'), obj, result, seams, turn, tilt);
    }

    async function open(file) {
        stop();
        Object.assign(state, { name: file.name, obj: null, result: null });
        element('save').disabled = true;
        try {
            state.obj = Obj.read(new Uint8Array(await file.arrayBuffer()));
        } catch (error) {
            return say(`${file.name}: ${error.message}`, true);
        }
        unwrap();
    }

    function save() {
        const blob = new Blob([Obj.write(state.obj, state.result.uv)], { type: 'model/obj' });
        const link = document.createElement('a');
        link.href = URL.createObjectURL(blob);
        link.download = state.name.replace(/(\.obj)?$/i, '_uv.obj');
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 60000);
    }

    // The whole page takes a drop, so that a near miss does not leave it.
    addEventListener('dragover', (event) => {
        event.preventDefault();
        element('drop').className = 'over';
    });
    addEventListener('dragleave', () => { element('drop').className = ''; });
    addEventListener('drop', (event) => {
        event.preventDefault();
        element('drop').className = '';
        if (event.dataTransfer.files.length) open(event.dataTransfer.files[0]);
    });
    element('file').onchange = ({ target }) => { if (target.files.length) open(target.files[0]); };
    element('asked').onsubmit = (event) => {
        event.preventDefault();
        unwrap();
    };
    element('stop').onclick = () => {
        stop();
        say(`${state.name}: stopped`);
    };
    element('save').onclick = save;
    element('mesh').onpointermove = (event) => {
        if (event.buttons !== 1) return;
        state.turn -= event.movementX / 150;
        state.tilt -= event.movementY / 150;
        requestAnimationFrame(draw);
    };
})();
