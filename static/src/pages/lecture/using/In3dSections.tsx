/** Maps in three dimensions, each with its scene. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect } from "preact/hooks";
import { Patch } from "../../../lessons/terrain/Patch";
import { Button } from "../../../ui/Button";
import type { Values } from "../../../wire/protocol";
import { pack } from "../../packed";
import { LaterFigure, OnStage, Section, type SectionHead, SectionLink } from "../Section";

export function OctreeSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={
        <OnStage scene="octree" label="The floor as an octree, cut at a height">
          <LaterFigure id="octree" />
        </OnStage>
      }
      sources={["octomap"]}
      after={
        <>
          <p>
            Halving the cell size of a dense grid makes <b>eight</b> times as many cells, most of them in empty rooms.
            An <b>octree</b> stores eight cells of one state as a single node, and has no nodes where nothing was
            measured: it grows with the surfaces, about <b>four</b> times. Each access descends from the root, and nodes
            are larger than cells, so here it saves memory only with fine cells.
          </p>
          <p>
            A <b>point cloud</b> keeps each reading; it grows with every scan and does not say what is free.
          </p>
        </>
      }
    >
      <p>
        The low table of <SectionLink to="low-table" /> is missing in a map on the laser’s plane, and a door with a low
        lintel appears free to a tall robot. A map of <b>cells in three dimensions</b>, voxels, shows both.{" "}
        <span class="no-print">Move the cut, then make the cells finer and compare the memory.</span>
      </p>
    </Section>
  );
}

interface LabLinkProps {
  readonly world: string;
  /** Parameters of the 3D map that differ from the initial ones. */
  readonly map3d: Values;
  readonly children: ComponentChildren;
}

const LAB = "/lab.html";

/** A link to a new world of the lab that starts with a 3D map of these parameters. */
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

export function TsdfSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<LaterFigure id="tsdf" />}
      sources={[["curless-levoy", "section 3"], ["newcombe", "section 3.3"], "octomap"]}
      after={
        <>
          <p>
            A reading <i>z</i> gives a voxel at distance <i>r</i> along the beam the distance <i>d</i> = <i>z</i> −{" "}
            <i>r</i>, and the voxel keeps the mean: <i>D</i> ← (weight · <i>D</i> + <i>d</i>) / (weight + 1); then its
            weight grows by 1. Noise averages out, and interpolation between two voxels gives the surface{" "}
            <b>more finely than a voxel</b>. The gradient of <i>D</i> is the normal of the surface.
          </p>
          <p>
            Distances are kept up to the <b>truncation</b>; farther behind the surface nothing is updated. In a wall
            thinner than that, readings from both sides fall into the same voxels. The weight stops at a{" "}
            <b>maximum weight</b>, so that the surface can follow a wall that moves.
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
        how far away the surface is: positive in front of it, negative behind, 0 on it.{" "}
        <span class="no-print">Drag the wall through a cell.</span>
      </p>
    </Section>
  );
}

export function TerrainSection(head: SectionHead) {
  return (
    <Section
      {...head}
      figure={<Patch />}
      sources={["ransac"]}
      after={
        <>
          <p>
            P = Σ v vᵀ with v = [1 <i>x</i> <i>y</i> <i>h</i>]ᵀ holds all sums that the fit needs: AᵀA is its upper left
            3 × 3 block, Aᵀh is in its last column, hᵀh in the corner. A new point adds one term and need not be kept.
            Patches add up: one of twice the size is the sum of four, which makes a quadtree.
          </p>
          <p>
            Two slips are common: the root in the slope is forgotten, and the residual hᵀh − … is not divided by{" "}
            <i>n</i>, so that it grows with every point. A patch is safe while slope and roughness, each divided by its
            limit, add up to at most 1; full systems weight them and add the step to the next patch. A stone tilts the
            least-squares plane; <b>RANSAC</b> finds the plane that most points agree with.
          </p>
        </>
      }
    >
      <p>
        Can a robot drive safely on this ground? The points of each <b>patch</b> of a grid get a plane <i>h</i> ={" "}
        <i>a</i> + <i>b x</i> + <i>c y</i> by least squares, (AᵀA)⁻¹Aᵀh, where A has a row [1 <i>x</i> <i>y</i>] and h
        the height of each point. From it come the slope cos⁻¹(1 / √(1 + <i>b</i>² + <i>c</i>²)), the mean height, and
        the roughness √(residual / <i>n</i>); the residual is the <b>sum</b> of the squared errors in height of the{" "}
        <i>n</i> points.{" "}
        <span class="no-print">
          Drag the points, and see which entries of the matrix P change and when the patch becomes unsafe.
        </span>
      </p>
    </Section>
  );
}
