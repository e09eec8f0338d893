import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { Button } from "../../ui/Button";
import type { Values } from "../../wire/protocol";
import { pack } from "../packed";

interface LabLinkProps {
  readonly world: string;
  /** Parameters of the 3D map that differ from the first ones. */
  readonly map3d: Values;
  readonly children: ComponentChildren;
}

const LAB = "/lab.html";

/** A link to a new world of the lab in which a 3D map with these parameters begins. */
export function LabLink({ world, map3d, children }: LabLinkProps) {
  const address = useSignal(LAB);
  const values = JSON.stringify(map3d);
  useEffect(() => {
    void pack({ story: { world, seed: 1 }, map3d: JSON.parse(values) as Values }).then((letters) => {
      address.value = `${LAB}#s=${letters}&group=map3d`;
    });
  }, [world, values]);
  return (
    <Button icon="cube" href={address.value}>
      {children}
    </Button>
  );
}
