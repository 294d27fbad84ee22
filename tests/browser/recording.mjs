// Writes a recording of two seconds in which the corners of the mouth of a face go up and back. Arguments: LANDMARKS.csv OUT.csv.

import { readFileSync, writeFileSync } from 'node:fs';

const [landmarks, out] = process.argv.slice(2);
const [head, ...rows] = readFileSync(landmarks, 'utf8').trim().split('\n').map((line) => line.split(','));
const at = ['landmark', 'x_mm', 'y_mm', 'z_mm'].map((name) => head.indexOf(name));
const points = rows.map((row) => [row[at[0]], ...at.slice(1).map((k) => Number(row[k]))]);
const lines = ['time_s,marker,x_mm,y_mm,z_mm'];
for (let frame = 0; frame < 120; frame++) {
  const time = frame / 60, lift = 5 * Math.sin((Math.PI * time) / 2) ** 2;
  for (const [name, x, y, z] of points) {
    // One marker is lost for a while.
    if (name === 'cheilion_r' && frame >= 40 && frame < 60) continue;
    const share = name.startsWith('cheilion') ? 1 : 0;
    lines.push([time.toFixed(4), name, x, y + share * lift, z - 0.5 * share * lift].join(','));
  }
}
writeFileSync(out, `${lines.join('\n')}\n`);
