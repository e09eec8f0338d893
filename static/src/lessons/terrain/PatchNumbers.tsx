/** P of a patch entry by entry, and what follows from it. */

import { written } from "../../ui/numbers";
import { type Limits, type Moments, type Plane, scoreOf, slopeWithoutRoot } from "./model";

const DEGREE = 180 / Math.PI;
const NAMES = ["1", "x", "y", "z"];

interface MatrixProps {
  readonly moments: Moments;
  /** P before the point that moved last was moved. */
  readonly before: Moments;
}

/** P as a table; entries that the newest move has changed are marked. */
export function Matrix({ moments, before }: MatrixProps) {
  return (
    <table class="patch-matrix" aria-label="P, the sum of p pᵀ">
      <thead>
        <tr>
          <th scope="col">P</th>
          {NAMES.map((name) => (
            <th scope="col" key={name}>
              {name}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {NAMES.map((name, row) => (
          <tr key={name}>
            <th scope="row">{name}</th>
            {NAMES.map((other, col) => {
              const now = moments[4 * row + col] as number;
              const isChanged = Math.abs(now - (before[4 * row + col] as number)) > 5e-3;
              return (
                <td key={other} class={isChanged ? "changed" : ""}>
                  {row + col === 0 ? written(now, 0) : written(now, 2)}
                </td>
              );
            })}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

interface ResultProps {
  readonly plane: Plane | null;
  /** What is just safe; without them no class is shown. */
  readonly limits?: Limits;
}

/** The plane, its residual, its slope, and the class that follows. */
export function Result({ plane, limits }: ResultProps) {
  if (!plane) return <p>These points give no plane.</p>;
  const { a, b, c, n, meanHeight, residual, roughness, slope } = plane;
  return (
    <div class="patch-result">
      <dl>
        <div>
          <dt>Plane</dt>
          <dd>
            z = {written(a, 2)} {b < 0 ? "−" : "+"} {written(Math.abs(b), 2)} x {c < 0 ? "−" : "+"}{" "}
            {written(Math.abs(c), 2)} y
          </dd>
        </div>
        <div>
          <dt>Points n = P₁₁</dt>
          <dd>{n}</dd>
        </div>
        <div>
          <dt>Mean height P₁₄ / n</dt>
          <dd>{written(meanHeight, 2)} m</dd>
        </div>
        <div>
          <dt>Residual, a sum of squares</dt>
          <dd>{written(residual, 3)} m²</dd>
        </div>
        <div>
          <dt>Roughness √(residual / n)</dt>
          <dd>{written(roughness, 3)} m</dd>
        </div>
        <div>
          <dt>Slope cos⁻¹(1 / √(1 + b² + c²))</dt>
          <dd>{written(slope * DEGREE, 1)}°</dd>
        </div>
        <div class="patch-slip">
          <dt>Without the root</dt>
          <dd>{written(slopeWithoutRoot(plane) * DEGREE, 1)}°, not the angle of the plane</dd>
        </div>
      </dl>
      {limits && <Class plane={plane} limits={limits} />}
    </div>
  );
}

function Class({ plane, limits }: { readonly plane: Plane; readonly limits: Limits }) {
  const score = scoreOf(plane, limits);
  const isSafe = score <= 1;
  return (
    <p class={`patch-class ${isSafe ? "safe" : "unsafe"}`} role="status">
      <b>{isSafe ? "Safe" : "Unsafe"}</b>: {written(plane.slope / limits.slope, 2)} for the slope +{" "}
      {written(plane.roughness / limits.roughness, 2)} for the roughness = {written(score, 2)},{" "}
      {isSafe ? "at most" : "above"} 1
    </p>
  );
}
