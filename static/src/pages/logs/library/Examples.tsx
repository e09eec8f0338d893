import { useSignal } from "@preact/signals";
import { Button } from "../../../ui/Button";
import { toastFailure } from "../../../ui/browser/attempts";
import { type ExampleName, openExample } from "./library";

interface Example {
  readonly name: ExampleName;
  readonly title: string;
  /** What to try with it. */
  readonly hint: string;
}

const EXAMPLES: readonly Example[] = [
  {
    name: "drift",
    title: "Poses that drift",
    hint: "Walls appear twice because the wheels slip a little. Press Heal: SLAM corrects the poses; then compare both maps.",
  },
  {
    name: "mount",
    title: "A wrong mount",
    hint: "The lidar is turned in its mount, by how much is not stated. The findings name it, with a button that corrects it.",
  },
  {
    name: "camera",
    title: "Camera and 3D lidar",
    hint: "Choose the layout Map and camera. The button Open in 3D on its card makes voxels: clip them to a box, click one.",
  },
];

/** Logs of the simulator for a visitor who has none. */
export function Examples() {
  const making = useSignal<ExampleName | null>(null);
  const begin = async (name: ExampleName): Promise<void> => {
    making.value = name;
    await toastFailure(() => openExample(name));
    making.value = null;
  };
  return (
    <section class="shelf">
      <h2>No log at hand?</h2>
      <ul class="cards">
        {EXAMPLES.map(({ name, title, hint }) => (
          <li key={name} class="card example-card">
            <h3>{title}</h3>
            <p>{hint}</p>
            <Button disabled={making.value !== null} onClick={() => void begin(name)}>
              {making.value === name ? "Simulating …" : `Open: ${title.charAt(0).toLowerCase()}${title.slice(1)}`}
            </Button>
          </li>
        ))}
      </ul>
    </section>
  );
}
