import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Choice } from "../../ui/Choice";
import { useInSight } from "../common/useInSight";
import { nowOf } from "../stage/nowOf";
import { SCENES } from "../stage/scenes";
import { asText, densityCharacter, stateCharacter } from "./density";
import "./pipeline.css";

const KINDS = [
  { value: "density", label: "density" },
  { value: "states", label: "three states" },
];

/** The map of the stage as characters. */
export function Terminal() {
  const kind = useSignal("density");
  const root = useRef<HTMLDivElement>(null);
  const { map } = nowOf(useInSight(root, SCENES.characters));
  const isDensity = kind.value === "density";
  return (
    <div class="terminal" ref={root}>
      <Choice
        label="The map as characters"
        options={KINDS}
        value={kind.value}
        onChange={(value) => {
          kind.value = value;
        }}
      />
      <p>
        {isDensity
          ? "By probability: # from 0.9, o from 0.7, + from 0.55, a space from 0.45, − from 0.3, and . below."
          : "By log-odds: # above +0.5, . below −0.5, ? between them."}
      </p>
      <pre role="img" aria-label={`The map as ${map.geometry.cols} × ${map.geometry.rows} characters`}>
        {asText(map, isDensity ? densityCharacter : stateCharacter)}
      </pre>
    </div>
  );
}
