" Made by tools/grammars.py from the tables of the language.
if exists('b:current_syntax')
  finish
endif
syntax keyword wmsStatement action action_text actions add answer called camera cause counterfactual design difference distinct each ensure factor film film_text from hide holdout horizon joint joints kinds legibility let license light margin may nuisance object objects observe options orbit order other parameter part question repeat require robot seen source stable state task template title to tolerance use variant within without world
syntax keyword wmsOperator about after among and apart as at by else false for if in not of only or then true under unless when with
syntax keyword wmsConstant above arc asphalt away back_and_forth ball behind below black blue blue_1 blue_2 blue_3 blue_4 blue_5 blue_6 blue_7 bounds box brick brown capsule carpet chalk checker circle cm concrete cone cube cyan cylinder depth dm end extrude fabric file fixed foot glass grass gray green hinge hull ids in_front_of inch index lathe leaf leather left left_of m marble metal mist mm nearer neither oak orange paper pieces pink plane planks plaster plastic purple red rgb right right_of rounded_box rubber sand slate slider sphere square stone straight stripes surface sweep tiles torus triangle tube walnut weave wedge white wood x y yellow z zigzag
syntax match wmsFunction /\<\(abs\|all\|angle\|any\|at_rest\|atan\|back\|behind\|between\|carry\|change_lane\|close\|contact\|contact_time\|contains\|contrast\|cos\|count\|darkest\|displacement\|distance\|drive\|drop\|extension\|fastest\|first\|fits\|floor\|follow\|force\|forward\|frame\|glide\|go_to\|grasp\|heading\|heads_to\|height\|highest\|impulse\|in_front_of\|largest\|launch\|left_of\|lift\|lightest\|longest\|look\|luminance\|max\|min\|mod\|move\|moved\|mover\|moving_time\|occluded\|onset\|open\|opposite\|paint\|pass_through\|pick\|place\|polar\|position\|push\|relation\|release\|rgb\|right_of\|rotate\|shade\|sin\|slide\|slowest\|smallest\|speed\|sqrt\|stop\|sum\|teleport\|tilt\|toppled\|touches_first\|toward\|trajectory\|turn\|vanish\|visible\|volume\|when_highest\)\ze(/
syntax match wmsProperty /\<[A-Za-z_]\w*\ze\s*:/
syntax match wmsNumber /\<\d\+\(\.\d\+\)\?\([eE][+-]\?\d\+\)\?\(\s*\(%\|[A-Za-z]\+\(\^-\?\d\+\)\?\([*\/][A-Za-z]\+\(\^-\?\d\+\)\?\)*\>\(\s*:\)\@!\)\)\?/ contains=wmsStatement,wmsOperator
syntax region wmsText start=/"/ skip=/\\./ end=/"\|$/ contains=wmsHole
syntax region wmsHole start=/{/ end=/}/ contained contains=TOP
syntax region wmsDoc start=/"""/ end=/"""/
syntax match wmsComment /#.*$/
highlight default link wmsStatement Statement
highlight default link wmsOperator Operator
highlight default link wmsConstant Constant
highlight default link wmsFunction Function
highlight default link wmsProperty Identifier
highlight default link wmsNumber Number
highlight default link wmsText String
highlight default link wmsHole Special
highlight default link wmsDoc Comment
highlight default link wmsComment Comment
setlocal commentstring=#\ %s
let b:current_syntax = 'wms'
