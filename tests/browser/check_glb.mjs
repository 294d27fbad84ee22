// Holds a GLB file to the glTF validator. Argument: FILE.glb.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

const bytes = new Uint8Array(readFileSync(process.argv[2]));
const { issues, info } = await validator.validateBytes(bytes, { maxIssues: 20 });
assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages, null, 1));
assert.equal(issues.numWarnings, 0, JSON.stringify(issues.messages, null, 1));
const length = new DataView(bytes.buffer).getUint32(12, true);
const document = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
const [skin] = document.meshes;
assert.equal(skin.extras.targetNames.length, skin.primitives[0].targets.length);
assert.equal(document.animations[0].name, 'rest to answer');
console.log(`the glTF validator finds no error: ${info.totalVertexCount} vertices, ${skin.extras.targetNames.length} morph targets`);
