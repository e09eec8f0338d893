import type { Tool } from "../../store/editing";
import type { Store } from "../../store/store";
import { Icon } from "../../ui/Icon";
import type { IconName } from "../../ui/iconPaths";
import "./toolbar.css";

const TOOLS: readonly { readonly tool: Tool; readonly icon: IconName; readonly label: string }[] = [
  { tool: "wall", icon: "wall", label: "Draw a wall" },
  { tool: "box", icon: "box", label: "Draw furniture" },
  { tool: "erase", icon: "erase", label: "Erase" },
];

/** The tools that edit the world: a wall, a box, the eraser. Pressing a selected tool deselects it. */
export function Toolbar({ store }: { readonly store: Store }) {
  const now = store.editing.tool.value;
  return (
    <div class="toolbar" role="toolbar" aria-label="Editing tools">
      {TOOLS.map(({ tool, icon, label }) => (
        <button
          key={tool}
          type="button"
          class="button quiet icon-only"
          aria-label={label}
          title={label}
          aria-pressed={tool === now}
          onClick={() => store.editing.take(tool === now ? null : tool)}
        >
          <Icon name={icon} />
        </button>
      ))}
    </div>
  );
}

/** One line about the selected tool; empty without one. */
export function ToolHint({ store }: { readonly store: Store }) {
  switch (store.editing.tool.value) {
    case "wall":
      return <p class="hint">Drag to draw a wall.</p>;
    case "box":
      return <p class="hint">Drag to draw a box between two corners.</p>;
    case "erase":
      return <p class="hint">Click a wall or a box to erase it. The outer wall cannot be erased.</p>;
    default:
      return null;
  }
}
