import { useSignal, useSignalEffect } from "@preact/signals";
import { isDark, printing } from "../../ui/theme";
import "./scene.css";

/** The 3D scene of a session in an iframe, in the colour scheme of this page. */
export function Scene({ session }: { readonly session: string }) {
  const dark = useSignal(isDark.peek());
  useSignalEffect(() => {
    if (!printing.value) dark.value = isDark.value;
  });
  const query = dark.value ? "?darkMode" : "";
  return (
    <div class="scene-group">
      <iframe class="scene" title="3D view" src={`/scenes/${encodeURIComponent(session)}/${query}`} />
      <a href={`/3d?session=${encodeURIComponent(session)}`} target="_blank" rel="noopener">
        Open in a new tab
      </a>
    </div>
  );
}
