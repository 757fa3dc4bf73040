// Runs the golden runs' module, which imports nothing, and prints its text: node .ci/run_wasm.js MODULE
const { readFileSync } = require('fs');
WebAssembly.instantiate(readFileSync(process.argv[2]), {}).then(({ instance: { exports: e } }) => {
    const code = e.run();
    process.stdout.write(Buffer.from(e.memory.buffer, e.text(), e.text_length()));
    process.exitCode = code;
});
