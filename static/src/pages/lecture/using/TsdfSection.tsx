import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { Button } from "../../../ui/Button";
import type { Values } from "../../../wire/protocol";
import { pack } from "../../packed";
import { LaterFigure, Section, type SectionHead } from "../Section";

interface LabLinkProps {
  readonly world: string;
  /** Parameters of the 3D map that differ from the first ones. */
  readonly map3d: Values;
  readonly children: ComponentChildren;
}

const LAB = "/lab.html";

/** A link to a new world of the lab in which a 3D map with these parameters begins. */
function LabLink({ world, map3d, children }: LabLinkProps) {
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

export function TsdfSection({ id, number, title }: SectionHead) {
  return (
    <Section
      id={id}
      number={number}
      title={title}
      figure={<LaterFigure id="tsdf" />}
      sources={[["curless-levoy", "section 3"], ["newcombe", "section 3.3"], "octomap"]}
      after={
        <>
          <p>
            A reading z gives a voxel at distance r along the beam the distance d = z − r, and the voxel keeps the mean:
            D ← (weight · D + d) / (weight + 1); then its weight grows by 1. Noise averages out, and interpolation
            between two voxels gives the surface <b>more finely than a voxel</b>. The gradient of D is the normal of the
            surface.
          </p>
          <p>
            Behind the <b>truncation</b> nothing is updated; a wall thinner than it gets readings of both sides into the
            same voxels. The weight stops at a <b>maximum weight</b>, so that the surface can follow a wall that moves.
          </p>
          <div class="actions no-print">
            <LabLink world="levels" map3d={{ kind: "tsdf", sensor: "depth_camera" }}>
              Open in the lab, in 3D
            </LabLink>
          </div>
        </>
      }
    >
      <p>
        An occupancy map says whether something is in a cell. A <b>truncated signed distance function (TSDF)</b> says
        how far away the surface is: positive in front of it, negative behind, 0 on it. The figure shows one beam and
        what both store of it. <span class="no-print">Drag the wall through a cell.</span>
      </p>
    </Section>
  );
}
