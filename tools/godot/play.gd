# Play the scene `scene.glb` to a second, and print the place of every joint as JSON: for each
# skeleton the names of its bones, and their positions in the world, metres.
#
#   godot3-server --path FOLDER -s play.gd SECONDS
extends SceneTree


func find_all(node, kind, found):
	if node.get_class() == kind:
		found.append(node)
	for child in node.get_children():
		find_all(child, kind, found)
	return found


func _init():
	var scene = load("res://scene.glb").instance()
	get_root().add_child(scene)
	var arguments = OS.get_cmdline_args()
	var player = find_all(scene, "AnimationPlayer", [])[0]
	player.play(player.get_animation_list()[0])
	player.seek(float(arguments[arguments.size() - 1]), true)
	var places = {}
	for skeleton in find_all(scene, "Skeleton", []):
		for bone in range(skeleton.get_bone_count()):
			var at = (skeleton.global_transform * skeleton.get_bone_global_pose(bone)).origin
			places[skeleton.get_bone_name(bone)] = [at.x, at.y, at.z]
	print("PLACES " + to_json(places))
	quit()
